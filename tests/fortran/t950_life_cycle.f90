!> Lives: objects that go out of scope, that are made anew, that stand in arrays and in other types.
!> Valgrind watches over memory.
module life_cycle_tests
  use, intrinsic :: iso_c_binding
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_life_cycle

  character(*), parameter :: file = 't950_life_cycle'

  type, extends(perion_function) :: steady
    integer :: calls = 0
  contains
    procedure :: evaluate => evaluate_steady
  end type steady

  type, extends(perion_progress) :: silent
    integer :: calls = 0
  contains
    procedure :: report => report_to_silent
  end type silent

  type, extends(perion_log) :: deaf
    integer :: calls = 0
  contains
    procedure :: take => take_deaf
  end type deaf

  !> A host's own object.
  type :: body
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation), allocatable :: simulation
  end type body

contains

  subroutine test_life_cycle()
    call run(file, 'what goes out of scope is freed', out_of_scope)
    call run(file, 'what is made anew frees what was there', made_anew)
    call run(file, 'arrays and parts of other types are freed', arrays_and_parts)
    call run(file, 'points and model can go once the simulation is there', copies)
    call run(file, 'destroying twice is fine', twice)
    call run(file, 'what has not been created can be assigned', nothing_assigned)
  end subroutine test_life_cycle

  subroutine evaluate_steady(self, time, positions, values, stop)
    class(steady), intent(inout) :: self
    real(c_double), intent(in) :: time
    real(c_double), intent(in) :: positions(:, :)
    real(c_double), intent(inout) :: values(:)
    logical, intent(inout) :: stop

    self%calls = self%calls + 1
    values = 0.001d0 * time
    stop = stop .or. size(positions, 2) /= size(values)
  end subroutine evaluate_steady

  subroutine report_to_silent(self, simulation, done, total, time, stop)
    class(silent), intent(inout) :: self
    type(perion_simulation), intent(in) :: simulation
    integer(c_int64_t), intent(in) :: done, total
    real(c_double), intent(in) :: time
    logical, intent(inout) :: stop
    type(perion_error), allocatable :: error
    real(c_double) :: now

    self%calls = self%calls + 1
    call simulation%time(now, error)
    stop = stop .or. allocated(error) .or. abs(now - time) > 0 .or. done > total
  end subroutine report_to_silent

  subroutine take_deaf(self, level, message)
    class(deaf), intent(inout) :: self
    integer(c_int32_t), intent(in) :: level
    character(*), intent(in) :: message

    if (level == PERION_LOG_LEVEL_WARNING .and. len(message) > 0) self%calls = self%calls + 1
  end subroutine take_deaf

  !> Everything that allocates; nothing is destroyed by hand.
  subroutine live(host, watch, log)
    type(steady), target, intent(inout) :: host
    type(silent), target, intent(inout) :: watch
    type(deaf), target, intent(inout) :: log
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_view) :: view
    type(perion_error), allocatable :: error

    call make_points(points)
    call points%add_set('some', [3, 1, 2])
    call make_model(model, brittle=.true.)
    call simulation%create(points, model)
    call simulation%set_log(log)
    call simulation%set_progress(watch)
    call simulation%prescribe_function('left', PERION_QUANTITY_VELOCITY, 1, host)
    call simulation%prescribe_function('right', PERION_QUANTITY_VELOCITY, 1, host)
    call simulation%prescribe_function('left', PERION_QUANTITY_VELOCITY, 1, host)
    call simulation%prescribe_table('right', PERION_QUANTITY_VELOCITY, 1, [0d0, 1d0], [0d0, 0.01d0])
    call simulation%break_bonds(reshape([1, 2, 1, 144], [2, 2]))
    call simulation%step(0.125d0, 5)
    call simulation%step(-1d0, 5, error)
    call simulation%borrow(PERION_FIELD_VELOCITY, view)
    view%data = 0
  end subroutine live

  subroutine out_of_scope()
    type(steady), target :: host
    type(silent), target :: watch
    type(deaf), target :: log

    call live(host, watch, log)
    call live(host, watch, log)
    ! A velocity is asked at the middle and the end of each step.
    call assert(host%calls == 20 .and. watch%calls == 10 .and. log%calls == 2, &
        'the callbacks were not called as often as they should')
  end subroutine out_of_scope

  subroutine made_anew()
    type(steady), target :: host
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    integer :: turn, count

    do turn = 1, 3
      call points%create_block([0d0, 0d0], [4d0, real(turn, c_double)], 1d0)
      call points%add_set_box('left', [0d0, 0d0], [1d0, 9d0])
      call make_model(model, brittle=.false.)
      call simulation%create(points, model)
      call simulation%prescribe_function('left', PERION_QUANTITY_VELOCITY, 1, host)
      call simulation%step(0.125d0, 1)
    end do
    call points%count(count)
    call assert(count == 12, 'the points are not the last ones')
    call points%create(reshape([0d0, 0d0, 1d0, 1d0], [2, 2]), [1d0, 1d0])
    call points%count(count)
    call assert(count == 2, 'the points are not the last ones')
  end subroutine made_anew

  subroutine arrays_and_parts()
    type(perion_points) :: points(2)
    type(perion_simulation), allocatable :: simulations(:), more(:)
    type(body), allocatable :: bodies(:)
    type(body) :: alone
    integer :: k

    allocate (simulations(3), bodies(2))
    call make_points(points(2))
    do k = 1, 2
      call make_plate(simulations(k), brittle=.false.)
      call make_points(bodies(k)%points)
      call make_model(bodies(k)%model, brittle=.false.)
    end do
    allocate (bodies(1)%simulation)
    call bodies(1)%simulation%create(bodies(1)%points, bodies(1)%model)
    call bodies(1)%simulation%step(0.125d0, 1)
    call make_points(alone%points)
    ! To move objects, with what they hold, move_alloc does.
    call move_alloc(simulations, more)
    call more(1)%step(0.125d0, 1)
    deallocate (more)
  end subroutine arrays_and_parts

  subroutine copies()
    real(c_double) :: density(plate_count)
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation

    call make_points(points)
    call make_model(model, brittle=.false.)
    call simulation%create(points, model)
    call points%destroy()
    call model%set('density', 9d0)
    call model%destroy()
    call simulation%get(PERION_FIELD_DENSITY, density)
    call assert(all(same_bits(density, 1d0)), 'the simulation has kept no copy of its model')
    call simulation%destroy()
  end subroutine copies

  subroutine twice()
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call make_points(points)
    call make_model(model, brittle=.false.)
    call simulation%destroy(error)
    call assert_fine(error)
    call simulation%destroy(error)
    call assert_fine(error)
    call points%destroy(error)
    call assert_fine(error)
    call points%destroy(error)
    call assert_fine(error)
    call model%destroy(error)
    call assert_fine(error)
    call model%destroy(error)
    call assert_fine(error)
  end subroutine twice

  subroutine nothing_assigned()
    type(perion_points) :: points, other_points(2), more_points(2)
    type(perion_model) :: model, other_model
    type(perion_simulation) :: simulation, other_simulation

    other_points = points
    more_points = other_points
    other_model = model
    other_simulation = simulation
    call make_plate(other_simulation, brittle=.false.)
    call make_steps(other_simulation, 1)
  end subroutine nothing_assigned

end module life_cycle_tests
