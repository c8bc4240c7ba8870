!> Driving: evaluate and commit for hosts that step themselves, step for all others, and callbacks.
module drive_tests
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_drive

  character(*), parameter :: file = 'drive.f90'

  !> What the callbacks below get and note.
  type :: watch
    type(c_ptr) :: simulation = c_null_ptr
    integer :: calls = 0, stop_at = huge(1)
    integer(c_int64_t) :: steps = -1, total = -1
    real(c_double) :: time = -1, time_asked = -2
    integer(c_int32_t) :: status_of_const = -1, status_of_change = -1, level = -1
    logical :: halting(size(ieee_usual)) = .false.
    character(:), allocatable :: message
  end type watch

contains

  subroutine test_drive()
    call run(file, 'evaluating breaks nothing and advances nothing', evaluate_is_pure)
    call run(file, 'a host that steps itself makes the same motion to the last bit', host_loop)
    call run(file, 'the clock is the host''s to set', clock)
    call run(file, 'a progress callback sees every step and may look', progress_looks)
    call run(file, 'a progress callback stops the run after the step it was told of', progress_stops)
    call run(file, 'a step above the stable one is logged, far above it refused', large_steps)
  end subroutine test_drive

  !> A velocity that tears the plate apart along x.
  subroutine tear(simulation, velocity)
    type(c_ptr), intent(in) :: simulation
    real(c_double), intent(inout) :: velocity(2, plate_count)
    real(c_double), parameter :: middle = 0.5_c_double * columns

    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_REFERENCE_POSITION, velocity, &
        2 * plate_count))
    velocity(1, :) = 0.01_c_double * (velocity(1, :) - middle)
    velocity(2, :) = 0
    call assert_ok(perion_simulation_set(simulation, PERION_FIELD_VELOCITY, velocity, 2 * plate_count))
  end subroutine tear

  subroutine evaluate_is_pure()
    real(c_double), dimension(2, plate_count) :: stretched, after, force, again
    real(c_double) :: time
    integer(c_int64_t) :: steps
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call tear(simulation, stretched)
    stretched = 10 * stretched
    call assert_ok(perion_simulation_set(simulation, PERION_FIELD_DISPLACEMENT, stretched, &
        2 * plate_count))
    call assert_ok(perion_simulation_evaluate(simulation))
    call assert(broken_bonds(simulation) == 0, 'evaluating breaks bonds')
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_INTERNAL_FORCE, force, &
        2 * plate_count))
    call assert_ok(perion_simulation_evaluate(simulation))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_INTERNAL_FORCE, again, &
        2 * plate_count))
    call assert(all(same_bits(force, again)), 'a second evaluation differs')
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, after, &
        2 * plate_count))
    call assert(all(same_bits(after, stretched)), 'evaluating moves points')
    call assert_ok(perion_simulation_time(simulation, time))
    call assert_ok(perion_simulation_step_count(simulation, steps))
    call assert(abs(time) <= 0 .and. steps == 0, 'evaluating advances')

    ! It is the commit that breaks.
    call assert_ok(perion_simulation_commit(simulation, 0.0_c_double))
    call assert(broken_bonds(simulation) > 0, 'a stretch of 0.1 breaks nothing')
    call assert_refused(perion_simulation_commit(simulation, -1.0_c_double), &
        PERION_ERROR_ARGUMENT, "'time_step' is -1")
    call destroy(simulation)
  end subroutine evaluate_is_pure

  subroutine host_loop()
    integer(c_int64_t), parameter :: steps = 40, length = 2 * plate_count
    real(c_double), dimension(2, plate_count) :: displacement, velocity, acceleration, expected
    real(c_double) :: time_step
    integer(c_int64_t) :: step, steps_made
    type(c_ptr) :: simulation, twin

    simulation = c_null_ptr
    twin = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call make_plate(twin, brittle=.true.)
    call tear(twin, velocity)
    call tear(simulation, velocity)
    call assert_ok(perion_simulation_stable_time_step(simulation, time_step))
    displacement = 0
    call assert_ok(perion_simulation_evaluate(simulation))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_ACCELERATION, acceleration, length))
    do step = 1, steps
      velocity = velocity + 0.5_c_double * time_step * acceleration
      displacement = displacement + time_step * velocity
      call assert_ok(perion_simulation_set(simulation, PERION_FIELD_DISPLACEMENT, displacement, &
          length))
      call assert_ok(perion_simulation_commit(simulation, time_step))
      call assert_ok(perion_simulation_evaluate(simulation))
      call assert_ok(perion_simulation_get(simulation, PERION_FIELD_ACCELERATION, acceleration, &
          length))
      velocity = velocity + 0.5_c_double * time_step * acceleration
    end do
    call assert_ok(perion_simulation_step_count(simulation, steps_made))
    call assert(steps_made == steps, 'commits are not counted as steps')

    call assert_ok(perion_simulation_step(twin, time_step, steps))
    call assert_ok(perion_simulation_get(twin, PERION_FIELD_DISPLACEMENT, expected, length))
    call assert(all(same_bits(displacement, expected)), 'the displacements differ')
    call assert_ok(perion_simulation_get(twin, PERION_FIELD_VELOCITY, expected, length))
    call assert(all(same_bits(velocity, expected)), 'the velocities differ')
    call assert(broken_bonds(simulation) > 0, 'nothing has broken')
    call assert(broken_bonds(simulation) == broken_bonds(twin), 'other bonds have broken')
    call destroy(simulation)
    call destroy(twin)
  end subroutine host_loop

  subroutine clock()
    real(c_double) :: time
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_set_time(simulation, 2.5_c_double))
    call assert_ok(perion_simulation_step(simulation, 0.125_c_double, 4_c_int64_t))
    call assert_ok(perion_simulation_time(simulation, time))
    call assert(same_bits(time, 3.0_c_double), 'four eighths after 2.5 is not 3')
    call assert_refused(perion_simulation_set_time(simulation, &
        transfer(int(z'7ff0000000000000', c_int64_t), time)), PERION_ERROR_ARGUMENT, "'time' is inf")
    call destroy(simulation)
  end subroutine clock

  !> Looks at the simulation, tries to change it, and stops the run when told to.
  function look(user, done, total, time) bind(c) result(stop_now)
    type(c_ptr), value :: user
    integer(c_int64_t), value :: done, total
    real(c_double), value :: time
    integer(c_int) :: stop_now
    type(watch), pointer :: host

    call c_f_pointer(user, host)
    host%calls = host%calls + 1
    host%steps = done
    host%total = total
    host%time = time
    call ieee_get_halting_mode(ieee_usual, host%halting)
    host%status_of_const = perion_simulation_time(host%simulation, host%time_asked)
    host%status_of_change = perion_simulation_step(host%simulation, time, 1_c_int64_t)
    stop_now = merge(1, 0, host%calls == host%stop_at)
  end function look

  subroutine progress_looks()
    logical :: halting(size(ieee_usual))
    type(watch), target :: host
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    host%simulation = simulation
    call assert_ok(perion_simulation_set_progress(simulation, c_funloc(look), c_loc(host)))
    call make_steps(simulation, 40)
    call assert(host%calls == 40 .and. host%steps == 40 .and. host%total == 40, &
        'it was not told of every step')
    call assert(host%status_of_const == PERION_OK, 'it may not look')
    call assert(same_bits(host%time, host%time_asked), 'it was told another time')
    call assert(host%status_of_change == PERION_ERROR_STATE, 'it may change the simulation')
    call ieee_get_halting_mode(ieee_usual, halting)
    call assert(all(host%halting .eqv. halting), 'it ran without the traps of its host')

    call assert_ok(perion_simulation_set_progress(simulation, c_null_funptr, c_null_ptr))
    call make_steps(simulation, 1)
    call assert(host%calls == 40, 'a callback that was taken away was called')
    call destroy(simulation)
  end subroutine progress_looks

  subroutine progress_stops()
    integer(c_int64_t) :: steps
    type(watch), target :: host
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    host%simulation = simulation
    host%stop_at = 7
    call assert_ok(perion_simulation_set_progress(simulation, c_funloc(look), c_loc(host)))
    call assert_refused(perion_simulation_step(simulation, 0.125_c_double, 40_c_int64_t), &
        PERION_ERROR_INTERRUPTED, 'stop after step 7 of 40')
    call assert_ok(perion_simulation_step_count(simulation, steps))
    call assert(steps == 7, 'the run did not stop after step 7')
    ! And goes on from there.
    call assert_ok(perion_simulation_step(simulation, 0.125_c_double, 33_c_int64_t))
    call assert(same_bits(host%time, 5.0_c_double), '40 steps of an eighth have not taken 5')
    call destroy(simulation)
  end subroutine progress_stops

  !> Keeps the last message.
  subroutine note(user, level, message) bind(c)
    type(c_ptr), value :: user
    integer(c_int32_t), value :: level
    character(kind=c_char), intent(in) :: message(*)
    type(watch), pointer :: host

    call c_f_pointer(user, host)
    host%calls = host%calls + 1
    host%level = level
    host%message = to_text(message)
  end subroutine note

  subroutine large_steps()
    real(c_double) :: stable
    type(perion_health) :: health
    type(watch), target :: host
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call assert_ok(perion_simulation_set_log(simulation, c_funloc(note), c_loc(host)))
    call assert_ok(perion_simulation_stable_time_step(simulation, stable))
    call assert_ok(perion_simulation_step(simulation, stable, 1_c_int64_t))
    call assert(host%calls == 0, 'a stable step is logged')
    call assert_ok(perion_simulation_step(simulation, 1.5_c_double * stable, 1_c_int64_t))
    call assert(host%calls == 1 .and. host%level == PERION_LOG_LEVEL_WARNING, 'no warning has come')
    call assert(index(host%message, '1.500 times') > 0, 'the message is: ' // host%message)
    call perion_health_init(health, c_sizeof(health))
    call assert_ok(perion_simulation_health(simulation, health))
    call assert(close_to(health%time_step_ratio, 1.5_c_double, 1e-15_c_double), &
        'health has another ratio')
    call assert_refused(perion_simulation_step(simulation, 11 * stable, 1_c_int64_t), &
        PERION_ERROR_ARGUMENT, 'at most 10 times')
    call assert_ok(perion_simulation_set_log(simulation, c_null_funptr, c_null_ptr))
    call destroy(simulation)
  end subroutine large_steps

end module drive_tests
