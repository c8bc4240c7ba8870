!> A plate of glass cracks and branches: the boundary tension test of Partmann et al. 2026, section 5.3.
!>
!> A plate of 100 x 40 x 4 mm has a crack from its left edge to its centre. At time 0 a tension of 1 MPa
!> is put on its upper and lower edge and held. The crack starts to run and splits in two.
!>
!> Usage: branching [points along the plate, 200] [output file, branching_fortran.pvd]
!>
!> What a host program does with Perion, in order: points, sets, model, simulation, conditions, step,
!> results. The same program stands beside this one in C and in Rust; all three print the same hash,
!> because the results are the same to the last bit.
!>
!> A call that fails ends the program with a text that says what went wrong and what to do, unless it is
!> given an `error` to put that into.
module branching_host
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit, real64
  use perion
  implicit none
  private
  public :: hash_values, seconds, watch

  !> Told after each step of the run: shows how far it is, twenty times, and writes the files.
  type, extends(perion_progress) :: watch
    character(500) :: series = ''
    real(real64) :: start = 0
    integer(int64) :: shown = 0
  contains
    procedure :: report
  end type watch

contains

  !> Perion calls this after each step. It may look at the simulation and write files; a `stop` that is
  !> true ends the run. It must come back to Perion: no `stop` and no `error stop` in here.
  subroutine report(self, simulation, done, total, time, stop)
    class(watch), intent(inout) :: self
    type(perion_simulation), intent(in) :: simulation
    integer(int64), intent(in) :: done, total
    real(real64), intent(in) :: time
    logical, intent(inout) :: stop
    type(perion_error), allocatable :: error
    real(real64) :: left

    if (20 * done / total == self%shown) return
    self%shown = 20 * done / total
    if (self%series /= '') then
      call simulation%write_series(self%series, [PERION_FIELD_DAMAGE, PERION_FIELD_DISPLACEMENT, &
          PERION_FIELD_VELOCITY, PERION_FIELD_STRAIN_ENERGY_DENSITY], error)
      if (allocated(error)) then
        write (error_unit, '(a)') error%message
        stop = .true.
        return
      end if
    end if
    left = (seconds() - self%start) * real(total - done, real64) / real(done, real64)
    print '(a, i5, a, i0, a, f5.1, a, f6.1, a)', 'step ', done, ' of ', total, ', ', 1d6 * time, &
        ' us, ', left, ' s left'
    flush (output_unit)
  end subroutine report

  !> Seconds since some moment in the past.
  function seconds()
    real(real64) :: seconds
    integer(int64) :: ticks, ticks_per_second

    call system_clock(ticks, ticks_per_second)
    seconds = real(ticks, real64) / real(ticks_per_second, real64)
  end function seconds

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

end module branching_host

program branching
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use branching_host
  use perion
  implicit none

  real(real64), parameter :: length = 0.1d0, height = 0.04d0, depth = 0.004d0  ! metres
  real(real64), parameter :: end_time = 50d-6  ! seconds
  real(real64), parameter :: traction = 1d6  ! pascals
  ! A rectangle, corner by corner, from the left edge to the centre of the plate.
  real(real64), parameter :: crack(3, 4) = reshape([0d0, 0d0, 0d0, length / 2, 0d0, 0d0, &
      length / 2, 0d0, depth, 0d0, 0d0, depth], [3, 4])

  type(perion_points) :: points
  type(perion_model) :: glass
  type(perion_simulation) :: simulation
  type(perion_energy) :: energy
  type(perion_health) :: health
  type(watch), target :: watching
  character(20) :: first_argument
  integer :: along, count, flaw, steps
  integer(int64) :: hash
  real(real64) :: spacing, lower(3), upper(3), body_force, stable
  real(real64), allocatable :: displacement(:, :), velocity(:, :), damage(:)

  along = 200
  watching%series = 'branching_fortran.pvd'
  flaw = 0
  call get_command_argument(1, first_argument)
  if (command_argument_count() > 0) read (first_argument, *, iostat=flaw) along
  if (command_argument_count() > 1) call get_command_argument(2, watching%series)
  if (flaw /= 0 .or. along < 10) then
    write (error_unit, '(a)') 'at least 10 points along the plate are needed'
    stop 1, quiet=.true.
  end if

  ! The points: a block, its lower left corner in the middle of the left edge. One layer of points
  ! along the upper edge and one along the lower are named, to pull on them.
  spacing = length / along
  lower = [0d0, -height / 2, 0d0]
  upper = [length, height / 2, depth]
  call points%create_block(lower, upper, spacing)
  call points%add_set_box('top', [0d0, height / 2 - spacing, 0d0], upper)
  call points%add_set_box('bottom', lower, [length, spacing - height / 2, depth])

  ! The material: soda-lime glass. Bond-based peridynamics takes one elastic constant, since its
  ! Poisson's ratio is 1/4. The energy release rate tells when bonds break.
  call glass%create('bond_based')
  call glass%set('youngs_modulus', 32d9)
  call glass%set('density', 2440d0)
  call glass%set('horizon', 3.015d0 * spacing)
  call glass%set('critical_energy_release_rate', 0.75d0)

  ! The simulation keeps copies, so points and model can go.
  call simulation%create(points, glass)
  call points%destroy()
  call glass%destroy()

  ! The crack that is there from the start: all bonds across it are broken.
  call simulation%break_crossing(crack)

  ! The tension, as a body force along the y axis on the named layers, whose bonds may not break.
  body_force = traction / spacing
  call simulation%prescribe('top', PERION_QUANTITY_BODY_FORCE, 2, body_force)
  call simulation%prescribe('bottom', PERION_QUANTITY_BODY_FORCE, 2, -body_force)
  call simulation%forbid_failure('top')
  call simulation%forbid_failure('bottom')

  ! Stepping: the library knows a step that is stable, and half of it where cracks stretch bonds.
  call simulation%point_count(count)
  call simulation%stable_time_step(stable)
  steps = ceiling(end_time / (0.5d0 * stable))
  print '(i0, a, i0, a, f6.4, a)', count, ' points, ', steps, ' steps of ', &
      1d6 * end_time / steps, ' us'
  watching%start = seconds()
  call simulation%set_progress(watching)
  call simulation%step(end_time / steps, steps)

  ! Results.
  call simulation%energy(energy)
  call simulation%health(health)
  print '(a, i0, a, i0)', 'broken bonds    ', health%broken_bonds, ' of ', health%bonds
  print '(a, f10.6, a)', 'external work   ', 1d3 * energy%external_work, ' mJ'
  print '(a, f10.6, a)', 'kinetic energy  ', 1d3 * energy%kinetic, ' mJ'
  print '(a, f10.6, a)', 'elastic energy  ', 1d3 * energy%elastic, ' mJ'
  print '(a, f10.6, a)', 'dissipated      ', 1d3 * energy%dissipated, ' mJ'
  print '(a, f10.6, a)', 'closure error   ', 1d2 * energy%closure_error / energy%external_work, &
      ' % of the work'
  allocate (displacement(3, count), velocity(3, count), damage(count))
  call simulation%get(PERION_FIELD_DISPLACEMENT, displacement)
  call simulation%get(PERION_FIELD_VELOCITY, velocity)
  call simulation%get(PERION_FIELD_DAMAGE, damage)
  hash = 0
  call hash_values(hash, 3 * count, displacement)
  call hash_values(hash, 3 * count, velocity)
  call hash_values(hash, count, damage)
  print '(a, z10.10)', 'hash            ', hash

  deallocate (displacement, velocity, damage)
  call simulation%destroy()
end program branching
