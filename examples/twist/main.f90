!> A bar is set spinning about its axis and twists by more than half a turn: large rotations without drift.
!>
!> After Partmann et al. 2026, section 4.5: a bar of 0.1 x 0.1 x 1 m, held at its lower end, starts with a
!> spin about its axis that grows from 0 at the held end to 150 1/s at the free one, along a quarter of a
!> sine. That is the lowest mode of torsion. The law of Saint Venant and Kirchhoff knows rotations, so
!> nothing else is needed for them, and correspondence stays calm as long as the motion is smooth.
!>
!> The paper names neither the material nor the end. Steel would turn by two degrees; here it is a soft
!> rubber, E = 2.5 MPa, nu = 1/4, 1000 kg/m3, which turns by more than half a turn. The run ends after half
!> a period, when the bar is back. The angle in equation 4.58 is taken to go all the way round.
!>
!> The stiffness against torsion is measured on the bar itself, as the energy that it takes to twist it: a
!> gradient averaged over families that the surface cuts is that of a place further inside, and so a bar
!> of few horizons is much softer than its material.
!>
!> Usage: twist [points across, 6; 30 in the paper] [curve, twist_fortran.csv]
!>              [output file, twist_fortran.pvd]
!>
!> In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units
!> are m, s and kg. The same program stands beside this one in C and in Rust; all three print the same
!> hash.
module twist_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none
  private
  public :: determinant, hash_values, twisted_energy, write_curve

  !> What is recorded.
  type, public :: record
    real(real64) :: time = 0         ! s
    real(real64) :: angle = 0        ! rad, by which the free end has turned
    real(real64) :: drift = 0        ! a share of the energy
    real(real64) :: determinant = 1  ! the least of the deformation gradient
  end type record

  real(real64), parameter, public :: pi = 3.14159265358979323846d0
  real(real64), parameter, public :: degrees = 57.29577951308232d0  ! in a radian

contains

  !> The energy per length of the layer in the middle when the bar is twisted by hand and its sections
  !> are warped as those of a square are, c x y (x^2 - y^2).
  function twisted_energy(bar, places, twisting, warping, spacing) result(energy)
    type(perion_simulation), intent(inout) :: bar
    real(real64), intent(in) :: places(:, :), twisting, warping, spacing
    real(real64) :: energy, density
    real(real64), allocatable :: displacement(:, :)

    allocate (displacement, mold=places)
    associate (x => places(1, :), y => places(2, :), z => places(3, :))
      displacement(1, :) = -twisting * y * z
      displacement(2, :) = twisting * x * z
      displacement(3, :) = twisting * (warping * x * y * (x * x - y * y))
    end associate
    call bar%set(PERION_FIELD_DISPLACEMENT, displacement)
    call bar%sum(PERION_FIELD_STRAIN_ENERGY_DENSITY, density, set='middle')
    displacement = 0
    call bar%set(PERION_FIELD_DISPLACEMENT, displacement)
    energy = density * spacing * spacing
  end function twisted_energy

  pure function determinant(f)
    real(real64), intent(in) :: f(3, 3)
    real(real64) :: determinant

    determinant = f(1, 1) * (f(2, 2) * f(3, 3) - f(2, 3) * f(3, 2)) &
        - f(1, 2) * (f(2, 1) * f(3, 3) - f(2, 3) * f(3, 1)) &
        + f(1, 3) * (f(2, 1) * f(3, 2) - f(2, 2) * f(3, 1))
  end function determinant

  !> The curve of the angle over time, with the names of its axes in the first line.
  subroutine write_curve(path, curve)
    character(*), intent(in) :: path
    type(record), intent(in) :: curve(:)
    integer :: unit, k

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') 'time (ms),angle (degrees)'
    write (unit, '(f10.4, ",", f12.5)') 0d0, 0d0, &
        (1d3 * curve(k)%time, degrees * curve(k)%angle, k=1, size(curve))
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

end module twist_host

program twist
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use twist_host
  implicit none

  integer, parameter :: records = 200
  real(real64), parameter :: width = 0.1d0, length = 1           ! m
  real(real64), parameter :: modulus = 2.5d6, density = 1000     ! Pa, kg/m3
  real(real64), parameter :: spin = 150                          ! rad/s
  real(real64), parameter :: half = 0.5d0 * width, end = 0.5d0 * length
  real(real64), parameter :: section = width * width
  real(real64), parameter :: twisting = 1d-4                     ! rad/m, by hand
  real(real64), parameter :: warping = 1 / (half * half)

  type(perion_points) :: points
  type(perion_model) :: rubber
  type(perion_simulation) :: bar
  type(perion_energy) :: energy
  type(record) :: curve(records), turn
  character(500) :: first_argument, path, series
  integer :: across, axis, count, flaw, number, point, steps, watched_count
  integer, allocatable :: watched(:)
  integer(int64) :: hash
  real(real64) :: spacing, less, plain, more, slope, curvature, stiffness
  real(real64) :: material_stiffness, inertia, quarter, linear, stable, interval
  real(real64) :: given, angle, turned, height, shortening
  real(real64), allocatable :: places(:, :), vectors(:, :), rate(:), gradients(:, :, :)

  across = 6
  path = 'twist_fortran.csv'
  series = 'twist_fortran.pvd'
  flaw = 0
  call get_command_argument(1, first_argument)
  if (command_argument_count() > 0) read (first_argument, *, iostat=flaw) across
  if (command_argument_count() > 1) call get_command_argument(2, path)
  if (command_argument_count() > 2) call get_command_argument(3, series)
  if (flaw /= 0 .or. across < 4) then
    write (error_unit, '(a)') 'at least 4 points across are needed'
    stop 1, quiet=.true.
  end if

  ! The points: a block, its axis the z axis. Its ends are named, three layers to hold, one to watch.
  spacing = width / across
  call points%create_block([-half, -half, -end], [half, half, end], spacing)
  call points%add_set_box('held', [-half, -half, -end], [half, half, 3 * spacing - end])
  call points%add_set_box('free', [-half, -half, end - spacing], [half, half, end])
  call points%add_set_box('middle', [-half, -half, 0d0], [half, half, spacing])
  call points%count(count)
  call points%set_size('free', watched_count)
  allocate (watched(watched_count), places(3, count))
  call points%get_set('free', watched)
  call points%get_coordinates(places)

  ! The material: a soft rubber, of Saint Venant and Kirchhoff, the default.
  call rubber%create('correspondence')
  call rubber%set('youngs_modulus', modulus)
  call rubber%set('poissons_ratio', 0.25d0)
  call rubber%set('density', density)
  call rubber%set('horizon', 3.015d0 * spacing)
  call bar%create(points, rubber)
  call points%destroy()
  call rubber%destroy()

  ! The stiffness against torsion, from a small twist: the energy is least for the warping that the bar
  ! takes.
  less = twisted_energy(bar, places, twisting, -warping, spacing)
  plain = twisted_energy(bar, places, twisting, 0d0, spacing)
  more = twisted_energy(bar, places, twisting, warping, spacing)
  slope = 0.5d0 * (more - less)
  curvature = 0.5d0 * (more + less) - plain
  stiffness = 2 * (plain - slope * slope / (4 * curvature)) / (twisting * twisting)

  ! The spin, counted from just above the held layers: equations 4.58 and 4.59.
  allocate (vectors(3, count), rate(count))
  rate = spin * sin(pi / (2 * length) * (places(3, :) + end - 3.01d0 * spacing))
  vectors(1, :) = -rate * places(2, :)
  vectors(2, :) = rate * places(1, :)
  vectors(3, :) = 0
  call bar%set(PERION_FIELD_VELOCITY, vectors)
  do axis = 1, 3
    call bar%prescribe('held', PERION_QUANTITY_VELOCITY, axis, 0d0)
  end do

  ! Linear torsion of what is free: waves of it run at sqrt(stiffness/inertia), and a quarter of a period
  ! takes them once along the bar. The material alone would make it 0.1406 mu width^4 stiff.
  material_stiffness = 0.1406d0 * (modulus / 2.5d0) * (section * section)
  inertia = density * (section * section) / 6 * (1 - 1d0 / across**2)
  quarter = (length - 3 * spacing) / sqrt(stiffness / inertia)
  linear = spin * quarter / (0.5d0 * pi)

  ! Stepping, through half a period, with a look at the bar 200 times. Shear makes this law stiffer: a
  ! tenth of the step that is stable now is kept back.
  call bar%stable_time_step(stable)
  interval = 2 * quarter / records
  steps = ceiling(interval / (0.9d0 * stable))
  print '(i0, a, i0, a, f6.4, a)', count, ' points, ', records * steps, ' steps of ', &
      1d3 * interval / steps, ' ms'
  print '(a)', '   time ms  angle deg  kinetic J  elastic J  least det F'
  call bar%energy(energy)
  given = energy%kinetic
  allocate (gradients(3, 3, count))
  angle = 0
  shortening = 0
  do number = 1, records
    call bar%step(interval / steps, steps)
    call bar%get(PERION_FIELD_POSITION, vectors)
    call bar%get(PERION_FIELD_DEFORMATION_GRADIENT, gradients)

    ! The angle of the free end: that of the rotation in its plane that fits its points best. Between
    ! two looks it turns by less than half a turn.
    associate (x => places(1, watched), y => places(2, watched), &
        u => vectors(1, watched), v => vectors(2, watched))
      turned = atan2(sum(x * v - y * u), sum(x * u + y * v)) - angle
    end associate
    angle = angle + (turned - 2 * pi * anint(turned / (2 * pi)))

    call bar%energy(energy)
    associate (now => curve(number))
      call bar%time(now%time)
      now%angle = angle
      now%drift = (energy%kinetic + energy%elastic) / given - 1
      now%determinant = minval([(determinant(gradients(:, :, point)), point=1, count)])
      if (angle > turn%angle) then
        turn = now
        height = sum(vectors(3, watched)) / watched_count
        shortening = 1 - (height + end) / (length - 0.5d0 * spacing)
      end if
      if (mod(number, 10) == 0) then
        print '(f10.3, 1x, f10.3, 2(1x, f10.4), 1x, f12.6)', 1d3 * now%time, degrees * angle, &
            energy%kinetic, energy%elastic, now%determinant
        if (series /= '') call bar%write_series(series, [PERION_FIELD_REFERENCE_POSITION, &
            PERION_FIELD_DISPLACEMENT, PERION_FIELD_VON_MISES_STRESS])
      end if
    end associate
  end do

  ! Results.
  print '(a, f10.4, a)', 'stiffness       ', stiffness, ' N m2'
  print '(a, f10.4, a)', '  material      ', material_stiffness, ' N m2'
  print '(a, f10.3, a)', 'greatest angle  ', degrees * turn%angle, ' degrees'
  print '(a, f10.3, a)', '  linear        ', degrees * linear, ' degrees'
  print '(a, f10.4, a)', '  its time      ', 1d3 * turn%time, ' ms'
  print '(a, f10.4, a)', '  linear        ', 1d3 * quarter, ' ms'
  print '(a, f10.4, a)', '  bar shorter by', 100 * shortening, ' %'
  print '(a, f10.4, a)', 'energy given    ', given, ' J'
  print '(a, f10.4, a)', 'largest drift   ', 100 * maxval(abs(curve%drift)), ' %'
  print '(a, f10.6)', 'least det F     ', minval(curve%determinant)
  hash = 0
  call bar%get(PERION_FIELD_DISPLACEMENT, vectors)
  call hash_values(hash, size(vectors), vectors)
  call bar%get(PERION_FIELD_VELOCITY, vectors)
  call hash_values(hash, size(vectors), vectors)
  print '(a, z10.10)', 'hash            ', hash
  if (path /= '') call write_curve(path, curve)

  call bar%destroy()
end program twist
