!> Views: the host works in the library's own arrays.
module views_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_views

  character(*), parameter :: file = 't650_views'

contains

  subroutine test_views()
    call run(file, 'what is written into a view is the field', writing_a_view)
    call run(file, 'a view to read is the field in the inner order', reading_a_view)
    call run(file, 'nothing changes the simulation until views are returned', loans_block_changes)
    call run(file, 'a value that is not finite keeps the view on loan', bad_values_stay_on_loan)
    call run(file, 'what cannot be lent or returned is refused', refused_views)
  end subroutine test_views

  subroutine writing_a_view()
    real(c_double) :: velocity(2, plate_count)
    integer :: point
    type(perion_view) :: view
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%borrow(PERION_FIELD_VELOCITY, view)
    call assert(all(shape(view%data) == [2, plate_count]), 'the shape differs')
    do point = 1, plate_count
      view%data(:, view%place(point)) = [1, -1] * (1d-3 * point)
    end do
    call simulation%return(view)
    call assert(.not. associated(view%data), 'the returned view still points somewhere')
    call simulation%get(PERION_FIELD_VELOCITY, velocity)
    do point = 1, plate_count
      call assert(all(same_bits(velocity(:, point), [1, -1] * (1d-3 * point))), &
          'a velocity is not what was written')
    end do
    call simulation%destroy()
  end subroutine writing_a_view

  subroutine reading_a_view()
    real(c_double) :: force(2, plate_count)
    integer(int64) :: point, places(plate_count)
    type(perion_view) :: view
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call simulation%borrow_const(PERION_FIELD_INTERNAL_FORCE, view)
    ! Const calls may be made meanwhile.
    call simulation%get(PERION_FIELD_INTERNAL_FORCE, force)
    places = view%place([(point, point = 1, int(plate_count, int64))])
    call assert(minval(places) == 1 .and. maxval(places) == plate_count, 'places do not count from 1')
    call assert(all(same_bits(view%data(:, places), force)), 'a force differs')
    call assert(any(abs(force) > 0), 'there is no force')
    call simulation%return(view)
    call simulation%destroy()
  end subroutine reading_a_view

  subroutine loans_block_changes()
    type(perion_view) :: view, again
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call simulation%borrow(PERION_FIELD_DISPLACEMENT, view)
    call simulation%step(0.1d0, 1, error)
    call assert_fails(error, PERION_ERROR_STATE, 'perion_simulation_return')
    call simulation%borrow_const(PERION_FIELD_VELOCITY, again, error)
    call assert_fine(error)
    call simulation%borrow_const(PERION_FIELD_VELOCITY, view, error)
    call assert_fails(error, PERION_ERROR_STATE, "perion_simulation_borrow_const: 'view' holds a field on loan")
    call simulation%borrow(PERION_FIELD_VELOCITY, again, error)
    call assert_fails(error, PERION_ERROR_STATE, 'perion_simulation_borrow: ''view'' holds a field on loan')
    call assert(associated(view%data) .and. associated(again%data), 'a refused call has cleared a view')
    call simulation%return(again)
    again = view
    call simulation%return(view)
    call simulation%return(again, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'not on loan')
    call simulation%step(0.1d0, 1)
    ! One that is still borrowed ends with the simulation.
    call simulation%borrow(PERION_FIELD_DISPLACEMENT, view)
    call simulation%destroy()
    call make_plate(simulation, brittle=.false.)
    call simulation%borrow(PERION_FIELD_DISPLACEMENT, view, error)
    call assert_fails(error, PERION_ERROR_STATE, 'view = perion_view()')
    view = perion_view()
    call simulation%borrow(PERION_FIELD_DISPLACEMENT, view)
    call simulation%return(view)
    call simulation%destroy()
  end subroutine loans_block_changes

  subroutine bad_values_stay_on_loan()
    type(perion_view) :: view
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call simulation%borrow(PERION_FIELD_VELOCITY, view)
    view%data(2, view%place(101)) = infinity()
    call simulation%return(view, error)
    call assert_fails(error, PERION_ERROR_NUMERIC, 'point 100')
    call assert(associated(view%data), 'a view that was refused is cleared')
    view%data(2, view%place(101)) = 0
    call simulation%return(view)
    call simulation%destroy()
  end subroutine bad_values_stay_on_loan

  subroutine refused_views()
    type(perion_view) :: view
    type(perion_simulation) :: simulation, other
    type(perion_error), allocatable :: error

    call simulation%borrow(PERION_FIELD_VELOCITY, view, error)
    call assert_fails(error, PERION_ERROR_NULL, 'the perion_simulation has not been created')
    call make_plate(simulation, brittle=.false.)
    call make_plate(other, brittle=.false.)
    call simulation%return(view, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "nothing is borrowed in 'view'")
    call simulation%borrow(PERION_FIELD_DAMAGE, view, error)
    call assert_fails(error, PERION_ERROR_UNSUPPORTED, 'damage')
    call simulation%borrow_const(PERION_FIELD_DAMAGE, view, error)
    call assert_fails(error, PERION_ERROR_UNSUPPORTED, 'damage')
    call simulation%borrow_const(PERION_FIELD_ACCELERATION, view, error)
    call assert_fails(error, PERION_ERROR_STATE, 'evaluate')
    call simulation%borrow(99, view, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'field' is 99")
    call assert(.not. associated(view%data), 'a refused call has filled a view')
    call simulation%borrow(PERION_FIELD_VELOCITY, view)
    call other%return(view, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'not on loan')
    call simulation%return(view)
    call simulation%destroy()
    call other%destroy()
  end subroutine refused_views

end module views_tests
