!> Driving: evaluate and commit for hosts that step themselves, step for all others; the clock.
module drive_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_drive

  character(*), parameter :: file = 't700_drive'

contains

  subroutine test_drive()
    call run(file, 'evaluating breaks nothing and advances nothing', evaluate_is_pure)
    call run(file, 'a host that steps itself makes the same motion to the last bit', host_loop)
    call run(file, 'a run lands on its time, in steps that are stable', run_to_a_time)
    call run(file, 'the clock is the host''s to set', clock)
    call run(file, 'nonsense is refused and changes nothing', nonsense_is_refused)
  end subroutine test_drive

  !> A velocity that tears the plate apart along the first axis.
  subroutine tear(simulation, velocity)
    type(perion_simulation), intent(inout) :: simulation
    real(c_double), intent(inout) :: velocity(:, :)
    real(c_double), parameter :: middle = 0.5d0 * columns

    call simulation%get(PERION_FIELD_REFERENCE_POSITION, velocity)
    velocity(1, :) = 0.01d0 * (velocity(1, :) - middle)
    velocity(2, :) = 0
    call simulation%set(PERION_FIELD_VELOCITY, velocity)
  end subroutine tear

  subroutine evaluate_is_pure()
    real(c_double), dimension(2, plate_count) :: stretched, after, force, again
    real(c_double) :: time
    integer :: steps
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call tear(simulation, stretched)
    stretched = 10 * stretched
    call simulation%set(PERION_FIELD_DISPLACEMENT, stretched)
    call simulation%evaluate()
    call assert(broken_bonds(simulation) == 0, 'evaluating breaks bonds')
    call simulation%get(PERION_FIELD_INTERNAL_FORCE, force)
    call simulation%evaluate()
    call simulation%get(PERION_FIELD_INTERNAL_FORCE, again)
    call assert(all(same_bits(force, again)), 'a second evaluation differs')
    call simulation%get(PERION_FIELD_DISPLACEMENT, after)
    call assert(all(same_bits(after, stretched)), 'evaluating moves points')
    call simulation%time(time)
    call simulation%step_count(steps)
    call assert(abs(time) <= 0 .and. steps == 0, 'evaluating advances')
    ! It is the commit that breaks.
    call simulation%commit(0d0)
    call assert(broken_bonds(simulation) > 0, 'a stretch of 0.1 breaks nothing')
    call simulation%destroy()
  end subroutine evaluate_is_pure

  subroutine host_loop()
    integer, parameter :: steps = 40
    real(c_double), dimension(2, plate_count) :: displacement, velocity, acceleration, expected
    real(c_double) :: time_step
    integer :: step
    integer(int64) :: steps_made
    type(perion_simulation) :: simulation, twin

    call make_plate(simulation, brittle=.true.)
    call make_plate(twin, brittle=.true.)
    call tear(twin, velocity)
    call tear(simulation, velocity)
    call simulation%stable_time_step(time_step)
    displacement = 0
    call simulation%evaluate()
    call simulation%get(PERION_FIELD_ACCELERATION, acceleration)
    do step = 1, steps
      velocity = velocity + 0.5d0 * time_step * acceleration
      displacement = displacement + time_step * velocity
      call simulation%set(PERION_FIELD_DISPLACEMENT, displacement)
      call simulation%commit(time_step)
      call simulation%evaluate()
      call simulation%get(PERION_FIELD_ACCELERATION, acceleration)
      velocity = velocity + 0.5d0 * time_step * acceleration
    end do
    call simulation%step_count(steps_made)
    call assert(steps_made == steps, 'commits are not counted as steps')

    call twin%step(time_step, steps)
    call twin%get(PERION_FIELD_DISPLACEMENT, expected)
    call assert(all(same_bits(displacement, expected)), 'the displacements differ')
    call twin%get(PERION_FIELD_VELOCITY, expected)
    call assert(all(same_bits(velocity, expected)), 'the velocities differ')
    call assert(broken_bonds(simulation) > 0, 'nothing has broken')
    call assert(broken_bonds(simulation) == broken_bonds(twin), 'other bonds have broken')
    call simulation%destroy()
    call twin%destroy()
  end subroutine host_loop

  subroutine run_to_a_time()
    real(c_double) :: stable, time
    type(perion_advance_options) :: options
    type(perion_report) :: report
    type(perion_health) :: health
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call pull(simulation)
    call simulation%stable_time_step(stable)
    call simulation%advance(10 * stable)
    call simulation%time(time)
    call assert(same_bits(time, 10 * stable), 'it has not landed on its time')
    options%largest_time_step = 0.25d0 * stable
    call simulation%advance(12 * stable, options, report)
    call assert(report%steps >= 8 .and. report%steps <= 9, 'not steps of a quarter')
    call assert(report%largest_time_step <= options%largest_time_step, 'a step is too long')
    call assert(same_bits(report%time, 12 * stable), 'the report tells another time')
    call simulation%health(health)
    call assert(health%stable_step_is_guaranteed == 1, 'the step is not guaranteed')
    call assert(same_bits(health%stable_time_step, report%stable_time_step), 'two stable steps')
    options%safety = 1.5d0
    call simulation%advance(13 * stable, options, report, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'safety' is 1.5")
    call assert(report%steps >= 8, 'a refused call has changed the report')
    call simulation%advance(11 * stable, error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'until' is")
    call simulation%destroy()
  end subroutine run_to_a_time

  subroutine clock()
    real(c_double) :: time
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%set_time(2.5d0)
    call simulation%step(0.125d0, 4_int64)
    call simulation%time(time)
    call assert(same_bits(time, 3d0), 'four eighths after 2.5 is not 3')
    call simulation%destroy()
  end subroutine clock

  subroutine nonsense_is_refused()
    real(c_double) :: stable
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    type(state) :: before, after

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 20)
    call take_state(simulation, before)
    call simulation%stable_time_step(stable)
    call simulation%step(-stable, 1, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'time_step' is -")
    call simulation%step(nan(), 1_int64, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'time_step' is NaN")
    call simulation%step(stable, -1, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'steps' is -1")
    call simulation%step(11 * stable, 1, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'at most 10 times')
    call simulation%commit(-1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'time_step' is -1")
    call simulation%set_time(infinity(), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'time' is inf")
    call simulation%step(stable, 0)
    call take_state(simulation, after)
    call assert(same(before, after), 'a refused call has changed the simulation')
    call simulation%destroy()
  end subroutine nonsense_is_refused

end module drive_tests
