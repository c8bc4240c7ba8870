!> Callbacks: functions, progress and log that look, stop, fail, call back, and are replaced.
module callback_tests
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_callbacks

  character(*), parameter :: file = 't910_callbacks'

  !> u_x = rate t y, a shear.
  type, extends(perion_function) :: shear
    real(c_double) :: rate = 0, third_value = 0
    integer :: calls = 0, stop_at = huge(1), fail_at = huge(1)
    logical :: halting(size(ieee_usual)) = .false.
  contains
    procedure :: evaluate => evaluate_shear
  end type shear

  !> Without a component: a function needs nothing to know.
  type, extends(perion_function) :: still
  contains
    procedure :: evaluate => evaluate_still
  end type still

  !> A body force that tries to use its simulation, and that takes steps with another.
  type, extends(perion_function) :: caller
    type(perion_simulation), pointer :: simulation => null(), other => null()
    integer :: refusals = 0
  contains
    procedure :: evaluate => evaluate_caller
  end type caller

  !> Looks at the simulation, tries to change it through a pointer, and stops the run when told to.
  type, extends(perion_progress) :: watch
    type(perion_simulation), pointer :: simulation => null()
    integer :: calls = 0, refusals = 0, stop_at = huge(1), borrow_at = huge(1)
    integer(c_int64_t) :: done = -1, total = -1
    real(c_double) :: time = -1, time_asked = -2
    logical :: halting(size(ieee_usual)) = .false.
    type(perion_view) :: view
  contains
    procedure :: report => report_to_watch
  end type watch

  !> Keeps the last message.
  type, extends(perion_log) :: notebook
    integer :: calls = 0
    integer(c_int32_t) :: level = -1
    character(:), allocatable :: message
  contains
    procedure :: take => take_note
  end type notebook

contains

  subroutine test_callbacks()
    call run(file, 'a function sees places and time and fills values', functions)
    call run(file, 'a function that stops leaves the last completed step', function_stops)
    call run(file, 'a function that gives an infinite value is told', function_gives_infinity)
    call run(file, 'functions are replaced, released, and live with their simulation', replaced)
    call run(file, 'a function may not call its simulation, but another', function_calls)
    call run(file, 'a progress object sees every step and may look, not change', progress_looks)
    call run(file, 'a progress object stops the run after the step it was told of', progress_stops)
    call run(file, 'a view lent to a callback ends the run', view_in_callback)
    call run(file, 'a step above the stable one is logged', large_steps)
    call run(file, 'a null pointer is no watcher', null_pointers)
  end subroutine test_callbacks

  subroutine evaluate_shear(self, time, positions, values, stop)
    class(shear), intent(inout) :: self
    real(c_double), intent(in) :: time
    real(c_double), intent(in) :: positions(:, :)
    real(c_double), intent(inout) :: values(:)
    logical, intent(inout) :: stop

    self%calls = self%calls + 1
    call ieee_get_halting_mode(ieee_usual, self%halting)
    values = self%rate * time * positions(2, :)
    if (self%calls == self%fail_at) values(3) = self%third_value
    stop = self%calls == self%stop_at
  end subroutine evaluate_shear

  subroutine evaluate_still(self, time, positions, values, stop)
    class(still), intent(inout) :: self
    real(c_double), intent(in) :: time
    real(c_double), intent(in) :: positions(:, :)
    real(c_double), intent(inout) :: values(:)
    logical, intent(inout) :: stop

    values = 0
    stop = stop .or. time < 0 .or. size(positions) == 0 .or. .not. same_type_as(self, self)
  end subroutine evaluate_still

  subroutine evaluate_caller(self, time, positions, values, stop)
    class(caller), intent(inout) :: self
    real(c_double), intent(in) :: time
    real(c_double), intent(in) :: positions(:, :)
    real(c_double), intent(inout) :: values(:)
    logical, intent(inout) :: stop
    type(perion_error), allocatable :: error
    real(c_double) :: now

    values = 0 * (time + positions(1, 1))
    if (associated(self%other)) then
      call self%other%step(0.125d0, 1, error)
      if (allocated(error)) stop = .true.
    end if
    call self%simulation%time(now, error)
    if (refused(error)) self%refusals = self%refusals + 1
    call self%simulation%step(0.125d0, 1, error)
    if (refused(error)) self%refusals = self%refusals + 1
    call self%simulation%destroy(error)
    if (refused(error)) self%refusals = self%refusals + 1
  end subroutine evaluate_caller

  function refused(error)
    type(perion_error), allocatable, intent(in) :: error
    logical :: refused

    refused = .false.
    if (allocated(error)) refused = error%status == PERION_ERROR_STATE
  end function refused

  subroutine report_to_watch(self, simulation, done, total, time, stop)
    class(watch), intent(inout) :: self
    type(perion_simulation), intent(in) :: simulation
    integer(c_int64_t), intent(in) :: done, total
    real(c_double), intent(in) :: time
    logical, intent(inout) :: stop
    type(perion_error), allocatable :: error
    real(c_double) :: velocity(2, plate_count)

    self%calls = self%calls + 1
    self%done = done
    self%total = total
    self%time = time
    call ieee_get_halting_mode(ieee_usual, self%halting)
    call simulation%time(self%time_asked, error)
    if (allocated(error)) stop = .true.
    call simulation%get(PERION_FIELD_VELOCITY, velocity, error=error)
    if (allocated(error)) stop = .true.
    if (done == self%borrow_at) call simulation%borrow_const(PERION_FIELD_VELOCITY, self%view, error)
    if (associated(self%simulation)) then
      call self%simulation%step(0.125d0, 1, error)
      if (refused(error)) self%refusals = self%refusals + 1
      call self%simulation%destroy(error)
      if (refused(error)) self%refusals = self%refusals + 1
      call make_plate_anew(self%simulation, error)
      if (refused(error)) self%refusals = self%refusals + 1
    end if
    if (done == self%stop_at) stop = .true.
  end subroutine report_to_watch

  !> Creating over a simulation that is in use must not take its place.
  subroutine make_plate_anew(simulation, error)
    type(perion_simulation), intent(inout) :: simulation
    type(perion_error), allocatable, intent(out) :: error
    type(perion_points) :: points
    type(perion_model) :: model

    call make_points(points)
    call make_model(model, brittle=.true.)
    call simulation%create(points, model, error)
  end subroutine make_plate_anew

  subroutine take_note(self, level, message)
    class(notebook), intent(inout) :: self
    integer(c_int32_t), intent(in) :: level
    character(*), intent(in) :: message

    self%calls = self%calls + 1
    self%level = level
    self%message = message
  end subroutine take_note

  subroutine functions()
    real(c_double), parameter :: step = 0.125d0
    logical :: halting(size(ieee_usual))
    real(c_double) :: at_left(2, rows)
    integer :: row
    type(shear), target :: host
    type(perion_simulation) :: simulation

    host%rate = 0.01d0
    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1, host)
    call simulation%step(step, 4)
    call assert(host%calls == 4, 'a displacement is not asked once a step')
    call simulation%get(PERION_FIELD_DISPLACEMENT, at_left, 'left')
    do row = 1, rows
      call assert(same_bits(at_left(1, row), host%rate * (4 * step) * (row - 0.5d0)), &
          'a point is not where the function puts it')
    end do
    call ieee_get_halting_mode(ieee_usual, halting)
    call assert(all(host%halting .eqv. halting), 'the function ran without the traps of its host')
    ! The host can change what the function knows between runs.
    host%rate = 0
    call simulation%step(step, 1)
    call simulation%get(PERION_FIELD_DISPLACEMENT, at_left, 'left')
    call assert(all(abs(at_left(1, :)) <= 0), 'the function has kept a copy of its object')
    call simulation%destroy()
  end subroutine functions

  subroutine function_stops()
    integer :: steps
    type(shear), target :: host
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    type(state) :: stopped, unstopped

    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1_int64, host)
    host%rate = 0.01d0
    host%stop_at = 3
    call simulation%step(0.125d0, 9, error)
    call assert_fails(error, PERION_ERROR_INTERRUPTED, "set 'left', axis 0, asked to stop at time 0.375")
    call assert_fails(error, PERION_ERROR_INTERRUPTED, '(points and axes in this text count from 0)')
    call simulation%step_count(steps)
    call assert(steps == 2, 'the third step was not the one that stopped')
    call simulation%step(0.125d0, 7)
    call take_state(simulation, stopped)
    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1, host)
    call simulation%step(0.125d0, 9)
    call take_state(simulation, unstopped)
    call assert(same(stopped, unstopped), 'the stopped run goes on elsewhere')
    call simulation%destroy()
  end subroutine function_stops

  subroutine function_gives_infinity()
    integer :: steps
    type(shear), target :: host
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    host%fail_at = 1
    host%third_value = infinity()
    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1, host)
    call simulation%step(0.125d0, 9, error)
    call assert_fails(error, PERION_ERROR_NUMERIC, 'inf for point 2 of the set')
    call simulation%step_count(steps)
    call assert(steps == 0, 'a step was made')
    call simulation%step(0.125d0, 9)
    call simulation%destroy()
  end subroutine function_gives_infinity

  subroutine replaced()
    type(shear), target :: first, second
    type(still), target :: rest
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    integer :: turn

    call make_plate(simulation, brittle=.false.)
    do turn = 1, 3
      call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1, first)
      call simulation%prescribe_function('right', PERION_QUANTITY_DISPLACEMENT, 1, rest)
      call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 2, second)
    end do
    call simulation%step(0.125d0, 2)
    call assert(first%calls == 2 .and. second%calls == 2, 'a function is not asked once a step')
    call simulation%prescribe_function('lefft', PERION_QUANTITY_DISPLACEMENT, 1, second, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'lefft'")
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 3, second, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'axes are 1 to 2')
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1, second)
    call simulation%step(0.125d0, 1)
    call assert(first%calls == 2 .and. second%calls == 4, 'the replaced function is still asked')
    call simulation%release('left', PERION_QUANTITY_DISPLACEMENT, 2)
    call simulation%prescribe('left', PERION_QUANTITY_DISPLACEMENT, 1, 0d0)
    call simulation%prescribe_values('right', PERION_QUANTITY_DISPLACEMENT, 1, spread(0d0, 1, rows))
    call simulation%step(0.125d0, 1)
    call assert(second%calls == 4, 'a function that was released or replaced is still asked')
    ! What is prescribed when the simulation ends goes with it.
    call simulation%prescribe_function('left', PERION_QUANTITY_DISPLACEMENT, 1, first)
    call simulation%prescribe_function('right', PERION_QUANTITY_BODY_FORCE, 1, rest)
    call simulation%destroy()
  end subroutine replaced

  subroutine function_calls()
    type(caller), target :: host
    type(perion_simulation), target :: simulation, other
    integer :: steps

    call make_plate(simulation, brittle=.false.)
    call make_plate(other, brittle=.false.)
    host%simulation => simulation
    host%other => other
    call simulation%prescribe_function('right', PERION_QUANTITY_DISPLACEMENT, 1, host)
    call simulation%step(0.125d0, 5)
    call assert(host%refusals == 15, 'a function may use its simulation')
    call other%step_count(steps)
    call assert(steps == 5, 'a function may not step another simulation')
    call simulation%destroy()
    call other%destroy()
  end subroutine function_calls

  subroutine progress_looks()
    logical :: halting(size(ieee_usual))
    type(watch), target :: host
    type(perion_simulation), target :: simulation

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    host%simulation => simulation
    call simulation%set_progress(host)
    call simulation%step(0.125d0, 40)
    call assert(host%calls == 40 .and. host%done == 40 .and. host%total == 40, &
        'it was not told of every step')
    call assert(same_bits(host%time, host%time_asked), 'it was told another time')
    call assert(host%refusals == 120, 'it may change the simulation')
    call ieee_get_halting_mode(ieee_usual, halting)
    call assert(all(host%halting .eqv. halting), 'it ran without the traps of its host')
    call simulation%set_progress()
    call make_steps(simulation, 1)
    call assert(host%calls == 40, 'a callback that was taken away was called')
    call simulation%destroy()
  end subroutine progress_looks

  subroutine progress_stops()
    integer :: steps
    type(watch), target :: host, next
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    host%stop_at = 7
    call simulation%set_progress(host)
    call simulation%step(0.125d0, 40, error)
    call assert_fails(error, PERION_ERROR_INTERRUPTED, 'stop after step 7 of 40')
    call simulation%step_count(steps)
    call assert(steps == 7, 'the run did not stop after step 7')
    ! And goes on from there, under another eye.
    call simulation%set_progress(next)
    call simulation%step(0.125d0, 33)
    call assert(same_bits(next%time, 5d0), '40 steps of an eighth have not taken 5')
    call assert(host%calls == 7 .and. next%calls == 33, 'the first is still told')
    call simulation%destroy()
  end subroutine progress_stops

  subroutine view_in_callback()
    integer :: steps
    type(watch), target :: host
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    host%borrow_at = 5
    call simulation%set_progress(host)
    call simulation%step(0.125d0, 40, error)
    call assert_fails(error, PERION_ERROR_STATE, 'view')
    call simulation%step_count(steps)
    call assert(steps == 5, 'the run did not end where the view was lent')
    call simulation%return(host%view)
    host%borrow_at = 0
    call simulation%step(0.125d0, 35)
    call simulation%destroy()
  end subroutine view_in_callback

  subroutine large_steps()
    real(c_double) :: stable
    type(perion_health) :: health
    type(notebook), target :: host, next
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call simulation%set_log(host)
    call simulation%stable_time_step(stable)
    call simulation%step(stable, 1)
    call assert(host%calls == 0, 'a stable step is logged')
    call simulation%step(1.5d0 * stable, 1)
    call assert(host%calls == 1 .and. host%level == PERION_LOG_LEVEL_WARNING, 'no warning has come')
    call assert(index(host%message, '1.500 times') > 0, 'the message is: ' // host%message)
    call simulation%health(health)
    call assert(close_to(health%time_step_ratio, 1.5d0, 1d-15), 'health has another ratio')
    call simulation%set_log(next)
    call simulation%break_bonds(reshape([1, plate_count], [2, 1]))
    call assert(host%calls == 1 .and. next%calls == 1, 'the pair without a bond is not told to the next')
    call simulation%set_log()
    call simulation%break_bonds(reshape([1, plate_count], [2, 1]))
    call assert(next%calls == 1, 'a log that was taken away is told')
    call simulation%destroy()
  end subroutine large_steps

  subroutine null_pointers()
    class(perion_progress), pointer :: no_progress
    class(perion_log), pointer :: no_log
    type(watch), target :: host
    type(notebook), target :: log
    type(perion_simulation) :: simulation

    no_progress => null()
    no_log => null()
    call make_plate(simulation, brittle=.true.)
    call simulation%set_progress(host)
    call simulation%set_progress(no_progress)
    call simulation%set_log(log)
    call simulation%set_log(no_log)
    call make_steps(simulation, 1)
    call simulation%break_bonds(reshape([1, plate_count], [2, 1]))
    call assert(host%calls == 0 .and. log%calls == 0, 'a null pointer leaves the old object')
    call simulation%destroy()
  end subroutine null_pointers

end module callback_tests
