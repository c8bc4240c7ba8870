!> Views: the host works in the library's own arrays through c_f_pointer.
module view_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_views

  character(*), parameter :: file = 'views.f90'

contains

  subroutine test_views()
    call run(file, 'what is written into a view is the field', writing_a_view)
    call run(file, 'a view to read is the field in the inner order', reading_a_view)
    call run(file, 'nothing changes the simulation until views are returned', loans_block_changes)
    call run(file, 'a value that is not finite keeps the view on loan', bad_values_stay_on_loan)
    call run(file, 'fields that are computed when asked for cannot be lent', derived_fields)
  end subroutine test_views

  !> The data of a view as a Fortran array, and the place (from 1) of each point in it.
  subroutine open_view(view, data, place)
    type(perion_view), intent(in) :: view
    real(c_double), pointer, intent(out) :: data(:)
    integer(c_int64_t), allocatable, intent(out) :: place(:)
    integer(c_int64_t), pointer :: slot(:)
    integer(c_int64_t) :: k

    call c_f_pointer(view%data, data, &
        [(view%count - 1) * view%point_stride + (view%components - 1) * view%component_stride + 1])
    allocate (place(view%count))
    if (c_associated(view%slot)) then
      call c_f_pointer(view%slot, slot, [view%count])
      place(:) = 1 + slot * view%point_stride
    else
      place(:) = [(1 + k * view%point_stride, k = 0, view%count - 1)]
    end if
  end subroutine open_view

  subroutine writing_a_view()
    real(c_double) :: velocity(2, plate_count)
    real(c_double), pointer :: data(:)
    integer(c_int64_t), allocatable :: place(:)
    integer(c_int64_t) :: point
    type(perion_view) :: view
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call perion_view_init(view, c_sizeof(view))
    call assert(view%struct_size == c_sizeof(view), 'the size of perion_view differs')
    call assert_ok(perion_simulation_borrow(simulation, PERION_FIELD_VELOCITY, view))
    call assert(view%count == plate_count .and. view%components == 2, 'the shape differs')
    call open_view(view, data, place)
    do point = 1, plate_count
      data(place(point)) = 1e-3_c_double * point
      data(place(point) + view%component_stride) = -1e-3_c_double * point
    end do
    call assert_ok(perion_simulation_return(simulation, view))
    call assert(.not. c_associated(view%data), 'the returned view still points somewhere')
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_VELOCITY, velocity, 2 * plate_count))
    do point = 1, plate_count
      call assert(all(same_bits(velocity(:, point), [1, -1] * (1e-3_c_double * point))), &
          'a velocity is not what was written')
    end do
    call destroy(simulation)
  end subroutine writing_a_view

  subroutine reading_a_view()
    real(c_double) :: force(2, plate_count)
    real(c_double), pointer :: data(:)
    integer(c_int64_t), allocatable :: place(:)
    integer(c_int64_t) :: point
    type(perion_view) :: view
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call perion_view_init(view, c_sizeof(view))
    call assert_ok(perion_simulation_borrow_const(simulation, PERION_FIELD_INTERNAL_FORCE, view))
    call open_view(view, data, place)
    ! Const calls may be made meanwhile.
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_INTERNAL_FORCE, force, &
        2 * plate_count))
    do point = 1, plate_count
      call assert(same_bits(data(place(point)), force(1, point)), 'a force along x differs')
      call assert(same_bits(data(place(point) + view%component_stride), force(2, point)), &
          'a force along y differs')
    end do
    call assert(any(abs(force) > 0), 'there is no force')
    call assert_ok(perion_simulation_return(simulation, view))
    call destroy(simulation)
  end subroutine reading_a_view

  subroutine loans_block_changes()
    type(perion_view) :: view, again
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call perion_view_init(view, c_sizeof(view))
    call assert_ok(perion_simulation_borrow(simulation, PERION_FIELD_DISPLACEMENT, view))
    call assert_refused(perion_simulation_step(simulation, 0.1_c_double, 1_c_int64_t), &
        PERION_ERROR_STATE, 'perion_simulation_return')
    again = view
    call assert_ok(perion_simulation_return(simulation, view))
    call assert_refused(perion_simulation_return(simulation, again), PERION_ERROR_ARGUMENT, &
        'not on loan')
    call assert_ok(perion_simulation_step(simulation, 0.1_c_double, 1_c_int64_t))
    call destroy(simulation)
  end subroutine loans_block_changes

  subroutine bad_values_stay_on_loan()
    real(c_double), pointer :: data(:)
    integer(c_int64_t), allocatable :: place(:)
    type(perion_view) :: view
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call perion_view_init(view, c_sizeof(view))
    call assert_ok(perion_simulation_borrow(simulation, PERION_FIELD_VELOCITY, view))
    call open_view(view, data, place)
    data(place(101)) = transfer(int(z'7ff0000000000000', c_int64_t), 0.0_c_double)
    call assert_refused(perion_simulation_return(simulation, view), PERION_ERROR_NUMERIC, 'point 100')
    call assert(c_associated(view%data), 'a view that was refused is cleared')
    data(place(101)) = 0
    call assert_ok(perion_simulation_return(simulation, view))
    call destroy(simulation)
  end subroutine bad_values_stay_on_loan

  subroutine derived_fields()
    type(perion_view) :: view
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    view%struct_size = 0
    call assert_refused(perion_simulation_borrow(simulation, PERION_FIELD_VELOCITY, view), &
        PERION_ERROR_ARGUMENT, 'struct_size')
    call perion_view_init(view, c_sizeof(view))
    call assert_refused(perion_simulation_borrow(simulation, PERION_FIELD_DAMAGE, view), &
        PERION_ERROR_UNSUPPORTED, 'damage')
    call assert_refused(perion_simulation_borrow_const(simulation, PERION_FIELD_DAMAGE, view), &
        PERION_ERROR_UNSUPPORTED, 'damage')
    call destroy(simulation)
  end subroutine derived_fields

end module view_tests
