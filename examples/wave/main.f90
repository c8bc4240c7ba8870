!> A wave in a bar: one end of a steel bar is struck, and the front runs at the speed of theory.
!>
!> The bar has 20 x 20 points across, 1 mm apart. Its end is brought to 1 m/s and kept at it. A front
!> that is long against the width of the bar runs at sqrt(E/rho). This E is measured on the bar itself,
!> as the energy that it takes to stretch it: points near the surface lack bonds, which makes a thin
!> bar softer than its material.
!>
!> Usage: wave [points along the bar, 200] [output file, wave_fortran.csv]
!>
!> In order: points and sets, model, simulation, a state set by hand, conditions, step, results. Units
!> are mm, ms and g, and so m/s, MPa and mJ. The same program stands beside this one in C and in Rust;
!> all three print the same hash.
module wave_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: hash_values, passing, write_matrix

contains

  !> The time at which a cross-section has reached a velocity, by a line between two records;
  !> velocities(0:) are those of the cross-section, one a record.
  function passing(velocities, velocity, interval) result(time)
    real(real64), intent(in) :: velocities(0:), velocity, interval
    real(real64) :: time
    integer :: after

    after = max(1, findloc(velocities >= velocity, .true., 1) - 1)
    time = interval * (after - (velocities(after) - velocity) &
        / (velocities(after) - velocities(after - 1)))
  end function passing

  !> A row for each record and a column for each cross-section; the first line tells what they are.
  subroutine write_matrix(path, velocities, end_time)
    character(*), intent(in) :: path
    real(real64), intent(in) :: velocities(:, 0:), end_time
    integer :: unit, record

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(2(a, f8.1), 2(a, f8.4), a)') 'x (mm),', 0.5d0, ',', size(velocities, 1) - 0.5d0, &
        ',t (us),', 0d0, ',', 1d3 * end_time, ',axial velocity (m/s)'
    do record = 0, ubound(velocities, 2)
      write (unit, '(*(f8.4, :, ","))') velocities(:, record)
    end do
    close (unit)
  end subroutine write_matrix

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

end module wave_host

program wave
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use wave_host
  implicit none

  integer, parameter :: across = 20, records = 200
  real(real64), parameter :: spacing = 1                            ! mm
  real(real64), parameter :: density = 7.8d-3, modulus = 210d3      ! g/mm3, MPa
  real(real64), parameter :: speed = 1                              ! mm/ms, of the struck end
  real(real64), parameter :: rise = 40                              ! mm, length of the front
  real(real64), parameter :: half = across * spacing / 2

  type(perion_points) :: points
  type(perion_model) :: steel
  type(perion_simulation) :: bar
  type(perion_energy) :: energy
  character(500) :: first_argument, matrix
  integer :: along, count, flaw, near, far, point, record, section, steps
  integer(int64) :: hash
  real(real64) :: length, volume, bar_modulus, expected, stable, interval, end_time
  real(real64) :: near_time, far_time, measured
  real(real64), allocatable :: vectors(:, :), velocities(:, :)
  real(real64), parameter :: stretch = 1d-5

  along = 200
  matrix = 'wave_fortran.csv'
  flaw = 0
  call get_command_argument(1, first_argument)
  if (command_argument_count() > 0) read (first_argument, *, iostat=flaw) along
  if (command_argument_count() > 1) call get_command_argument(2, matrix)
  if (flaw /= 0 .or. along < 50) then
    write (error_unit, '(a)') 'at least 50 points along the bar are needed'
    stop 1, quiet=.true.
  end if

  ! The points: a block, its axis the x axis. Its first layers are named, to strike them.
  length = along * spacing
  call points%create_block([0d0, -half, -half], [length, half, half], spacing)
  call points%add_set_box('struck', [0d0, -half, -half], [3 * spacing, half, half])
  call points%count(count)

  ! The material: steel that does not break.
  call steel%create('bond_based')
  call steel%set('youngs_modulus', modulus)
  call steel%set('density', density)
  call steel%set('horizon', 3.015d0 * spacing)
  call bar%create(points, steel)

  ! The modulus of the bar: it is stretched by hand, and narrows by Poisson's ratio 1/4 of that. Its
  ! energy is 1/2 E stretch^2 volume. Then it is let go.
  allocate (vectors(3, count))
  call points%get_coordinates(vectors)
  vectors(1, :) = vectors(1, :) * stretch
  vectors(2:3, :) = vectors(2:3, :) * (-0.25d0 * stretch)
  call bar%set(PERION_FIELD_DISPLACEMENT, vectors)
  call bar%energy(energy)
  call bar%sum(PERION_FIELD_VOLUME, volume)
  bar_modulus = 2 * energy%elastic / (stretch * stretch * volume)
  expected = sqrt(bar_modulus / density)
  vectors = 0
  call bar%set(PERION_FIELD_DISPLACEMENT, vectors)
  call points%destroy()
  call steel%destroy()

  ! The blow: the velocity of the first layers grows smoothly, by a table of times and velocities.
  call bar%prescribe_table('struck', PERION_QUANTITY_VELOCITY, 1, &
      rise / expected * [0d0, 0.25d0, 0.5d0, 0.75d0, 1d0], &
      speed * [0d0, 0.15625d0, 0.5d0, 0.84375d0, 1d0])

  ! Stepping, until the front has been reflected at the far end. 200 times on the way the mean axial
  ! velocity of each cross-section is taken: x runs fastest in a block of points.
  call bar%stable_time_step(stable)
  end_time = (1.5d0 * length + rise) / expected
  interval = end_time / records
  steps = ceiling(interval / (0.5d0 * stable))
  allocate (velocities(along, 0:records), source=0d0)
  print '(i0, a, i0, a, f6.4, a)', count, ' points, ', records * steps, ' steps of ', &
      1d3 * interval / steps, ' us'
  do record = 1, records
    call bar%step(interval / steps, steps)
    call bar%get(PERION_FIELD_VELOCITY, vectors)
    do point = 1, count
      section = 1 + mod(point - 1, along)
      velocities(section, record) = velocities(section, record) + vectors(1, point) / across**2
    end do
  end do

  ! Results: the front is where half the speed of the blow is first reached.
  near = 3 * along / 10
  far = 7 * along / 10
  near_time = passing(velocities(near + 1, :), 0.5d0 * speed, interval)
  far_time = passing(velocities(far + 1, :), 0.5d0 * speed, interval)
  measured = (far - near) * spacing / (far_time - near_time)
  call bar%energy(energy)
  print '(a, f10.4, a)', 'modulus         ', 1d-3 * bar_modulus, ' GPa'
  print '(a, f10.2, a)', 'sqrt(E/rho)     ', expected, ' m/s'
  print '(a, f10.4, a, i0, a)', 'front passes    ', 1d3 * near_time, ' us at ', near, ' mm'
  print '(a, f10.4, a, i0, a)', '                ', 1d3 * far_time, ' us at ', far, ' mm'
  print '(a, f10.2, a)', 'its speed       ', measured, ' m/s'
  print '(a, f10.2, a)', 'deviation       ', 100 * (measured / expected - 1), ' %'
  print '(a, f10.4, a)', 'closure error   ', 100 * energy%closure_error / energy%external_work, &
      ' % of the work'
  hash = 0
  call bar%get(PERION_FIELD_DISPLACEMENT, vectors)
  call hash_values(hash, size(vectors), vectors)
  call bar%get(PERION_FIELD_VELOCITY, vectors)
  call hash_values(hash, size(vectors), vectors)
  print '(a, z10.10)', 'hash            ', hash
  if (matrix /= '') call write_matrix(matrix, velocities, end_time)

  call bar%destroy()
end program wave
