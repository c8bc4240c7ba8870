!> A tensile test: a flat specimen of PMMA with a hole in its middle is pulled until it breaks.
!>
!> The specimen is 120 mm long, 3 mm thick and 12 mm wide where it is narrow; its mesh was written by
!> Gmsh. One grip is held and the other is pulled at 0.5 m/s, slowly enough for the specimen to stay in
!> balance until it breaks beside the hole.
!>
!> Usage: specimen [mesh, examples/specimen/specimen.msh] [curve, specimen_fortran.csv]
!>                 [output file, specimen_fortran.pvd]
!>
!> In order: points and sets from the mesh, model, simulation, conditions, step, results. Perion takes
!> any units that fit together: here mm, ms and g, and so m/s, N, MPa and mJ. The same program stands
!> beside this one in C and in Rust; all three print the same hash.
module specimen_host
  use, intrinsic :: iso_c_binding, only: c_int32_t
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none
  private
  public :: hash_values, record, sum_along, write_curve

  !> What is recorded in the test.
  type :: record
    real(real64) :: displacement = 0   !< how far the right grip has come, mm
    real(real64) :: force = 0          !< on the right grip, N
    real(real64) :: left_force = 0     !< on the left grip, N: the same backwards, while there is balance
    real(real64) :: kinetic_share = 0  !< kinetic over elastic energy: small, while there is balance
    real(real64) :: dissipated = 0     !< spent on broken bonds, mJ
  end type record

contains

  !> The sum of the first component of a field over a set.
  function sum_along(simulation, field, set) result(first)
    type(perion_simulation), intent(in) :: simulation
    integer(c_int32_t), intent(in) :: field
    character(*), intent(in) :: set
    real(real64) :: first, components(2)

    call simulation%sum(field, components, set)
    first = components(1)
  end function sum_along

  !> The curve of force over displacement, with the names of its axes in the first line.
  subroutine write_curve(path, curve)
    character(*), intent(in) :: path
    type(record), intent(in) :: curve(:)
    integer :: unit, number

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') 'displacement (mm),force (N)'
    write (unit, '(f10.6, ",", f12.4)') 0d0, 0d0
    do number = 1, size(curve)
      write (unit, '(f10.6, ",", f12.4)') curve(number)%displacement, curve(number)%force
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

end module specimen_host

program specimen
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  use specimen_host
  implicit none

  real(real64), parameter :: thickness = 3  ! mm
  real(real64), parameter :: speed = 0.5d0, ramp = 0.3d0, end_time = 0.72d0  ! mm/ms, ms, ms
  integer, parameter :: records = 200

  type(perion_points) :: points
  type(perion_model) :: pmma
  type(perion_simulation) :: simulation
  type(perion_energy) :: energy
  type(perion_health) :: health
  type(record) :: curve(records)
  character(500) :: mesh, path, series
  integer :: count, grip_points, number, steps, intact, peak
  integer(int64) :: hash
  real(real64) :: spacing, stable, interval, time_step, time
  real(real64), allocatable :: areas(:), vectors(:, :), damage(:)

  mesh = 'examples/specimen/specimen.msh'
  path = 'specimen_fortran.csv'
  series = 'specimen_fortran.pvd'
  if (command_argument_count() > 0) call get_command_argument(1, mesh)
  if (command_argument_count() > 1) call get_command_argument(2, path)
  if (command_argument_count() > 2) call get_command_argument(3, series)

  ! The points: one for each element of the mesh, with its area, at its centroid. The mesh names the
  ! elements in the grips; the sets of their points have these names.
  call points%read(mesh)
  call points%count(count)
  call points%set_size('right_grip', grip_points)
  allocate (areas(count))
  call points%get_volumes(areas)
  spacing = sqrt(sum(areas) / count)

  ! The material: PMMA, which breaks without yielding. In plane stress bond-based peridynamics has a
  ! Poisson's ratio of 1/3, which is near to that of PMMA.
  call pmma%create('bond_based')
  call pmma%choose('plane', 'stress')
  call pmma%set('thickness', thickness)
  call pmma%set('youngs_modulus', 3200d0)                ! MPa
  call pmma%set('density', 1.18d-3)                      ! g/mm3
  call pmma%set('horizon', 3 * spacing)                  ! mm
  call pmma%set('critical_energy_release_rate', 0.5d0)   ! N/mm

  ! The simulation keeps copies, so points and model can go.
  call simulation%create(points, pmma)
  call points%destroy()
  call pmma%destroy()

  ! The left grip is held, the right one is pulled. Its speed grows smoothly, so that the specimen is
  ! not struck: a table of times and velocities.
  call simulation%prescribe('left_grip', PERION_QUANTITY_VELOCITY, [0d0, 0d0])
  call simulation%prescribe_table('right_grip', PERION_QUANTITY_VELOCITY, 1, &
      ramp * [0d0, 0.25d0, 0.5d0, 0.75d0, 1d0], speed * [0d0, 0.15625d0, 0.5d0, 0.84375d0, 1d0])
  call simulation%prescribe('right_grip', PERION_QUANTITY_VELOCITY, 2, 0d0)
  call simulation%forbid_failure('left_grip')
  call simulation%forbid_failure('right_grip')

  ! Stepping, with a look at the specimen 200 times: how far its right grip has come, and the force on
  ! it, which is the sum of what holds its points.
  call simulation%stable_time_step(stable)
  interval = end_time / records
  steps = ceiling(interval / (0.5d0 * stable))
  time_step = interval / steps
  print '(i0, a, f6.4, a)', count, ' points, ', spacing, ' mm apart'
  print '(i0, a, f6.4, a)', records * steps, ' steps of ', 1d3 * time_step, ' us'
  print '(a)', '   time us  displacement mm    force N'
  do number = 1, records
    call simulation%step(time_step, steps)
    call simulation%energy(energy)
    curve(number)%displacement = sum_along(simulation, PERION_FIELD_DISPLACEMENT, 'right_grip') &
        / grip_points
    curve(number)%force = sum_along(simulation, PERION_FIELD_REACTION, 'right_grip')
    curve(number)%left_force = sum_along(simulation, PERION_FIELD_REACTION, 'left_grip')
    curve(number)%kinetic_share = energy%kinetic / energy%elastic
    curve(number)%dissipated = energy%dissipated
    if (mod(number, 10) == 0) then
      call simulation%time(time)
      print '(f10.1, f17.4, f11.2)', 1d3 * time, curve(number)%displacement, curve(number)%force
      if (series /= '') call simulation%write_series(series, &
          [PERION_FIELD_DAMAGE, PERION_FIELD_DISPLACEMENT, PERION_FIELD_STRAIN_ENERGY_DENSITY])
    end if
  end do

  ! Results. The stiffness is the slope of the line through the origin that fits the first half of the
  ! way to the greatest force.
  intact = findloc(curve%dissipated > 0, .true., 1) - 1
  peak = maxloc(curve%force, 1)
  call simulation%health(health)
  associate (early => curve%displacement < 0.5d0 * curve(peak)%displacement)
    print '(a, f10.2, a)', 'stiffness       ', sum(curve%force * curve%displacement, early) &
        / sum(curve%displacement**2, early), ' N/mm'
  end associate
  print '(a, f10.4, a)', 'intact up to    ', curve(intact)%displacement, ' mm'
  print '(a, f10.2, a)', '  force         ', curve(intact)%force, ' N'
  print '(a, f10.2, a)', '  left grip     ', curve(intact)%left_force, ' N'
  print '(a, f10.4, a)', '  kinetic       ', 100 * curve(intact)%kinetic_share, &
      ' % of the elastic energy'
  print '(a, f10.2, a)', 'greatest force  ', curve(peak)%force, ' N'
  print '(a, f10.4, a)', '  displacement  ', curve(peak)%displacement, ' mm'
  print '(a, i10, a, i0)', 'broken bonds    ', health%broken_bonds, ' of ', health%bonds
  print '(a, f10.4, a)', 'external work   ', energy%external_work, ' mJ'
  print '(a, f10.4, a)', 'kinetic energy  ', energy%kinetic, ' mJ'
  print '(a, f10.4, a)', 'elastic energy  ', energy%elastic, ' mJ'
  print '(a, f10.4, a)', 'dissipated      ', energy%dissipated, ' mJ'
  print '(a, f10.4, a)', 'closure error   ', 100 * energy%closure_error / energy%external_work, &
      ' % of the work'
  allocate (vectors(2, count), damage(count))
  hash = 0
  call simulation%get(PERION_FIELD_DISPLACEMENT, vectors)
  call hash_values(hash, size(vectors), vectors)
  call simulation%get(PERION_FIELD_VELOCITY, vectors)
  call hash_values(hash, size(vectors), vectors)
  call simulation%get(PERION_FIELD_DAMAGE, damage)
  call hash_values(hash, size(damage), damage)
  print '(a, z10.10)', 'hash            ', hash
  if (path /= '') call write_curve(path, curve)

  call simulation%destroy()
end program specimen
