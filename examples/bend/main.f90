!> A bar is bent until its ends nearly touch: large displacements and rotations, as an elastica has them.
!>
!> After Partmann et al. 2026, section 4.5: a bar of 0.2 x 0.01 x 0.01 m, E = 2.3 GPa, nu = 1/4,
!> 1600 kg/m3, with a slight curvature, here an arc of radius 2 m, so that it bends and is not just
!> pressed. The inner edges of its two ends are moved towards each other, and the bar is free to rotate
!> about them. The horizon is 0.64 widths as in the paper, 5.15 spacings with 8 points across.
!>
!> The paper takes 0.2 s for it. The lowest mode of bending swings in 15 ms, and a pull that starts
!> gently leaves it nearly at rest in 0.03 s: the height of a bent bar grows as the square root of the way
!> of its ends, so the way begins as the fourth power of time.
!>
!> The stiffness against bending is that of the best of some displacements made by hand, which the bar
!> itself undercuts. It lies far below E I: a gradient averaged over families that the surface cuts is
!> that of a place further inside. The shape of an elastica is the same for any stiffness.
!>
!> Usage: bend [points across, 4; 8 in the paper] [time in s, 0.03; 0.2 in the paper]
!>             [curve, bend_fortran.csv] [output file, bend_fortran.pvd]
!>
!> In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units
!> are m, s and kg. The same program stands beside this one in C and in Rust; all three print the same
!> hash.
module bend_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none
  private
  public :: create_arc, bent_energy, hash_values, write_curve

  real(real64), parameter, public :: length = 0.2d0, width = 0.01d0  ! m
  real(real64), parameter, public :: arc_radius = 2                  ! m

  !> What is recorded.
  type, public :: record
    real(real64) :: shortening  ! m, by which the edges have come together
    real(real64) :: height      ! m, of the axis of the bar in its middle, over the edges
    real(real64) :: force       ! N, on one edge, towards the other
  end type record

contains

  !> The points: a lattice laid along an arc, one row after the other, with its middle uppermost. The
  !> lower edges of its ends are named, and its section in the middle.
  subroutine create_arc(points, across)
    type(perion_points), intent(inout) :: points
    integer, intent(in) :: across
    real(real64), allocatable :: coordinates(:, :, :), volumes(:, :)
    real(real64) :: spacing, y, z, angle, radius
    integer :: along, rows, i, row, k

    along = 20 * across
    rows = across * across
    spacing = width / across
    allocate (coordinates(3, along, rows), volumes(along, rows))
    do row = 1, rows
      y = (mod(row - 1, across) + 0.5d0) * spacing - 0.5d0 * width
      z = ((row - 1) / across + 0.5d0) * spacing - 0.5d0 * width
      radius = arc_radius + y
      do i = 1, along
        angle = ((i - 0.5d0) * spacing - 0.5d0 * length) / arc_radius
        coordinates(:, i, row) = [radius * sin(angle), radius * cos(angle) - arc_radius, z]
      end do
      volumes(:, row) = spacing * spacing * spacing * (radius / arc_radius)
    end do
    call points%create(reshape(coordinates, [3, along * rows]), reshape(volumes, [along * rows]))
    call points%add_set('left', [(1 + k * across * along, k=0, across - 1)])
    call points%add_set('right', [(along + k * across * along, k=0, across - 1)])
    call points%add_set('middle', [(along / 2 + 1 + row * along, row=0, rows - 1)])
  end subroutine create_arc

  !> The energy per length of the section in the middle when the bar is bent by hand and contracts across.
  function bent_energy(bar, places, curvature, contraction, spacing) result(energy)
    type(perion_simulation), intent(inout) :: bar
    real(real64), intent(in) :: places(:, :), curvature, contraction, spacing
    real(real64) :: energy, density
    real(real64), allocatable :: displacement(:, :)

    allocate (displacement, mold=places)
    associate (x => places(1, :), y => places(2, :), z => places(3, :))
      displacement(1, :) = -curvature * x * y
      displacement(2, :) = 0.5d0 * curvature * (x * x + contraction * (y * y - z * z))
      displacement(3, :) = curvature * contraction * y * z
    end associate
    call bar%set(PERION_FIELD_DISPLACEMENT, displacement)
    call bar%sum(PERION_FIELD_STRAIN_ENERGY_DENSITY, density, set='middle')
    displacement = 0
    call bar%set(PERION_FIELD_DISPLACEMENT, displacement)
    energy = density * spacing * spacing
  end function bent_energy

  !> The curve of the height over the shortening, then the force, with the names of its columns in the
  !> first line.
  subroutine write_curve(path, curve)
    character(*), intent(in) :: path
    type(record), intent(in) :: curve(:)
    integer :: unit, k

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') 'shortening (mm),height (mm),force (N)'
    do k = 1, size(curve)
      write (unit, '(2(f10.4, ","), f11.3)') 1d3 * curve(k)%shortening, 1d3 * curve(k)%height, &
          curve(k)%force
    end do
    close (unit)
  end subroutine write_curve

  !> Goes on with a fingerprint of the bits of numbers.
  subroutine hash_values(hash, length, values)
    integer(int64), intent(inout) :: hash
    integer, intent(in) :: length
    real(real64), intent(in) :: values(length)
    integer(int64), parameter :: factor = 65599, modulus = 1099511627689_int64
    integer(int64), parameter :: lower_half = int(z'ffffffff', int64)
    integer(int64) :: bits
    integer :: k

    do k = 1, length
      bits = transfer(values(k), bits)
      hash = mod(hash * factor + iand(bits, lower_half), modulus)
      hash = mod(hash * factor + shiftr(bits, 32), modulus)
    end do
  end subroutine hash_values

end module bend_host

program bend
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use bend_host
  implicit none

  integer, parameter :: records = 200
  real(real64), parameter :: modulus = 2.3d9                 ! Pa
  real(real64), parameter :: gap = 0.01d0                    ! m, between the edges at the end
  real(real64), parameter :: curvature = 1d-3                ! 1/m, by hand
  real(real64), parameter :: section = width * width
  real(real64), parameter :: instants(*) = [0d0, 0.1d0, 0.2d0, 0.3d0, 0.4d0, 0.8d0, 1d0]
  real(real64), parameter :: shares(*) = [0d0, 0.015625d0, 0.125d0, 0.421875d0, 1d0, 1d0, 0d0]

  type(perion_points) :: points
  type(perion_model) :: polymer
  type(perion_simulation) :: bar
  type(perion_energy) :: energy
  type(perion_health) :: health
  type(record) :: curve(records)
  character(500) :: argument, path, series
  integer :: across, count, flaw, number, steps
  integer, allocatable :: left(:), middle(:)
  integer(int64) :: hash
  real(real64) :: duration, spacing, less, plain, more, slope, bow, stiffness
  real(real64) :: start, speed, stable, interval, time, force(3)
  real(real64), allocatable :: places(:, :), vectors(:, :)

  across = 4
  duration = 0.03d0
  path = 'bend_fortran.csv'
  series = 'bend_fortran.pvd'
  flaw = 0
  call get_command_argument(1, argument)
  if (command_argument_count() > 0) read (argument, *, iostat=flaw) across
  call get_command_argument(2, argument)
  if (command_argument_count() > 1 .and. flaw == 0) read (argument, *, iostat=flaw) duration
  if (command_argument_count() > 2) call get_command_argument(3, path)
  if (command_argument_count() > 3) call get_command_argument(4, series)
  if (flaw /= 0 .or. across < 3 .or. .not. (duration > 0 .and. duration <= 1)) then
    write (error_unit, '(a)') 'at least 3 points across and a time of at most 1 s are needed'
    stop 1, quiet=.true.
  end if

  spacing = width / across
  call create_arc(points, across)
  call points%count(count)
  allocate (places(3, count), vectors(3, count), left(across), middle(across * across))
  call points%get_coordinates(places)
  call points%get_set('left', left)
  call points%get_set('middle', middle)

  ! The material: a polymer, of Saint Venant and Kirchhoff, the default.
  call polymer%create('correspondence')
  call polymer%set('youngs_modulus', modulus)
  call polymer%set('poissons_ratio', 0.25d0)
  call polymer%set('density', 1600d0)                 ! kg/m3
  call polymer%set('horizon', 5.15d0 / 8 * width)
  call bar%create(points, polymer)
  call points%destroy()
  call polymer%destroy()

  ! The stiffness against bending, from a small curvature: the energy of the section in the middle is
  ! least for the contraction across that the bar takes, which in a thick bar is Poisson's ratio.
  less = bent_energy(bar, places, curvature, 0d0, spacing)
  plain = bent_energy(bar, places, curvature, 0.25d0, spacing)
  more = bent_energy(bar, places, curvature, 0.5d0, spacing)
  slope = 0.5d0 * (more - less)
  bow = 0.5d0 * (more + less) - plain
  stiffness = 2 * (plain - slope * slope / (4 * bow)) / (curvature * curvature)

  ! The edges move along x alone, by a table of times and velocities: a cubic start, then a steady pull.
  start = places(1, left(1))
  speed = (-start - 0.5d0 * gap) / (0.60625d0 * duration)
  call bar%prescribe_table('left', PERION_QUANTITY_VELOCITY, 1, instants * duration, shares * speed)
  call bar%prescribe_table('right', PERION_QUANTITY_VELOCITY, 1, instants * duration, -shares * speed)
  call bar%prescribe('left', PERION_QUANTITY_VELOCITY, 2, 0d0)
  call bar%prescribe('right', PERION_QUANTITY_VELOCITY, 2, 0d0)

  ! Stepping, with a look at the bar 200 times. A tenth of the step that is stable now is kept back,
  ! since bonds on the outer side become stiffer.
  call bar%stable_time_step(stable)
  interval = duration / records
  steps = ceiling(interval / (0.9d0 * stable))
  print '(i0, a, i0, a, f6.4, a)', count, ' points, ', records * steps, ' steps of ', &
      1d6 * interval / steps, ' us'
  print '(a)', '   time ms  shortening mm  height mm    force N  elastic J'
  do number = 1, records
    call bar%step(interval / steps, steps)
    call bar%get(PERION_FIELD_POSITION, vectors)
    call bar%sum(PERION_FIELD_REACTION, force, set='left')
    call bar%energy(energy)
    associate (now => curve(number))
      now%shortening = 2 * (sum(vectors(1, left)) / size(left) - start)
      now%height = sum(vectors(2, middle)) / size(middle) - sum(vectors(2, left)) / size(left)
      now%force = force(1)
      if (mod(number, 10) == 0) then
        call bar%time(time)
        print '(f10.3, 1x, f14.4, 1x, f10.4, 1x, f10.3, 1x, f10.5)', 1d3 * time, &
            1d3 * now%shortening, 1d3 * now%height, now%force, energy%elastic
        if (series /= '') call bar%write_series(series, [PERION_FIELD_DISPLACEMENT, &
            PERION_FIELD_VON_MISES_STRESS, PERION_FIELD_STRAIN_ENERGY_DENSITY])
      end if
    end associate
  end do

  ! Results.
  call bar%health(health)
  print '(a, f10.4, a)', 'stiffness below ', stiffness, ' N m2'
  print '(a, f10.4, a)', '  material      ', modulus * (section * section) / 12, ' N m2'
  print '(a, f10.4, a)', 'shortening      ', 1d3 * curve(records)%shortening, ' mm'
  print '(a, f10.4, a)', 'height          ', 1d3 * curve(records)%height, ' mm'
  print '(a, f10.3, a)', 'force           ', curve(records)%force, ' N'
  print '(a, f10.5)', 'least stretch   ', health%smallest_stretch
  print '(a, f10.4, a)', 'kinetic energy  ', 100 * energy%kinetic / energy%elastic, &
      ' % of the elastic energy'
  print '(a, f10.4, a)', 'closure error   ', 100 * energy%closure_error / energy%external_work, &
      ' % of the work'
  hash = 0
  call bar%get(PERION_FIELD_DISPLACEMENT, vectors)
  call hash_values(hash, size(vectors), vectors)
  call bar%get(PERION_FIELD_VELOCITY, vectors)
  call hash_values(hash, size(vectors), vectors)
  print '(a, z10.10)', 'hash            ', hash
  if (path /= '') call write_curve(path, curve)

  call bar%destroy()
end program bend
