!> The C interface as it is, `perion_c`, for hosts that want no module between: a bar that is
!> pulled, with each kind of argument that C has.
module raw_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use testing, only: assert, run
  implicit none
  private
  public :: test_raw

  character(*), parameter :: file = 't050_raw'
  integer(c_int64_t), parameter :: count = 20

contains

  subroutine test_raw()
    call run(file, 'a bar is pulled through the raw interfaces', bar)
    call run(file, 'a raw refusal is a status and a text', refusal)
    call run(file, 'structs have the size that the library knows', sizes)
  end subroutine test_raw

  !> Velocity of the left end, handed back as the user's pointer.
  function pull(user, time, length, reference_positions, values) bind(c) result(stop_now)
    type(c_ptr), value :: user
    real(c_double), value :: time
    integer(c_int64_t), value :: length
    real(c_double), intent(in) :: reference_positions(*)
    real(c_double), intent(inout) :: values(*)
    integer(c_int) :: stop_now
    real(c_double), pointer :: velocity

    call c_f_pointer(user, velocity)
    values(:length) = velocity
    stop_now = merge(0, 1, time >= 0 .and. reference_positions(1) < 1)
  end function pull

  subroutine bar()
    type(c_ptr) :: points, model, simulation
    real(c_double), target :: velocity
    real(c_double) :: displacement(2, count), force(2)
    real(c_double), pointer :: data(:, :)
    integer(c_int64_t), pointer :: slot(:)
    integer(c_int64_t) :: bonds, point, place
    type(perion_view) :: view
    procedure(perion_function), pointer :: function

    points = c_null_ptr
    model = c_null_ptr
    simulation = c_null_ptr
    velocity = -0.02d0
    call ok(perion_points_create_block(2, [0d0, 0d0], [10d0, 2d0], 1d0, points))
    call ok(perion_points_add_set(points, 'left' // c_null_char, 2_c_int64_t, [0_c_int64_t, 10_c_int64_t]))
    call ok(perion_model_create('bond_based' // c_null_char, model))
    call ok(perion_model_set(model, 'density' // c_null_char, 1d0))
    call ok(perion_model_set(model, 'youngs_modulus' // c_null_char, 1d0))
    call ok(perion_model_set(model, 'horizon' // c_null_char, 2.015d0))
    call ok(perion_simulation_create(points, model, simulation))
    call ok(perion_points_destroy(points))
    call ok(perion_model_destroy(model))
    call assert(.not. (c_associated(points) .or. c_associated(model)), 'a handle is not null')

    function => pull
    call ok(perion_simulation_prescribe_function(simulation, 'left' // c_null_char, &
        PERION_QUANTITY_VELOCITY, 0, c_funloc(function), c_loc(velocity)))
    call ok(perion_simulation_step(simulation, 0.25d0, 4_c_int64_t))
    call ok(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, displacement, 2 * count))
    call assert(abs(displacement(1, 11) + 0.02d0) < 1d-15, 'the left end is not where it was pulled')
    call ok(perion_simulation_sum(simulation, PERION_FIELD_REACTION, components=force))
    call assert(force(1) < 0, 'the grip does not pull')
    call ok(perion_simulation_get_bonds(simulation, 0_c_int64_t, count=bonds))
    call assert(bonds > count, 'there are no bonds')

    call perion_view_init(view, c_sizeof(view))
    call ok(perion_simulation_borrow_const(simulation, PERION_FIELD_DISPLACEMENT, view))
    call c_f_pointer(view%data, data, [view%point_stride, view%count])
    do point = 1, count
      place = point
      if (c_associated(view%slot)) then
        call c_f_pointer(view%slot, slot, [view%count])
        place = slot(point) + 1
      end if
      call assert(all(abs(data(:2, place) - displacement(:, point)) <= 0), 'the view differs')
    end do
    call ok(perion_simulation_return(simulation, view))
    call ok(perion_simulation_destroy(simulation))
  end subroutine bar

  subroutine refusal()
    type(c_ptr) :: model

    model = c_null_ptr
    call assert(perion_model_create('bond_baced' // c_null_char, model) == PERION_ERROR_ARGUMENT, &
        'an unknown formulation is taken')
    call assert(.not. c_associated(model), 'a refused call has made a model')
    call assert(c_associated(perion_last_error()), 'there is no text')
  end subroutine refusal

  subroutine sizes()
    type(perion_energy) :: energy
    type(perion_health) :: health
    type(perion_memory) :: memory

    call perion_energy_init(energy, c_sizeof(energy))
    call perion_health_init(health, c_sizeof(health))
    call perion_memory_init(memory, c_sizeof(memory))
    call assert(energy%struct_size == c_sizeof(energy), 'the size of perion_energy differs')
    call assert(health%struct_size == c_sizeof(health), 'the size of perion_health differs')
    call assert(memory%struct_size == c_sizeof(memory), 'the size of perion_memory differs')
    energy%struct_size = 0
    call assert(perion_simulation_energy(c_null_ptr, energy) /= PERION_OK, 'nothing has energy')
  end subroutine sizes

  subroutine ok(status)
    integer(c_int32_t), intent(in) :: status

    call assert(status == PERION_OK, 'a raw call has failed')
  end subroutine ok

end module raw_tests
