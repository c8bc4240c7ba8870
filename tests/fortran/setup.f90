!> Set-up of a simulation: materials by set, interfaces, what may not fail, and threads.
module setup_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_setup

  character(*), parameter :: file = 'setup.f90'

contains

  subroutine test_setup()
    call run(file, 'a model that lacks its density makes no simulation', incomplete_model)
    call run(file, 'a null handle is refused', null_handles)
    call run(file, 'a set gets a material of its own until set-up ends', materials_by_set)
    call run(file, 'a weak interface breaks, and nothing else', weak_interface)
    call run(file, 'bonds that may not fail stay', forbidden_failure)
    call run(file, 'the number of threads changes no bit', threads_change_nothing)
  end subroutine test_setup

  subroutine incomplete_model()
    type(c_ptr) :: points, model, simulation

    points = c_null_ptr
    model = c_null_ptr
    simulation = c_null_ptr
    call make_plate_points(points)
    call assert_ok(perion_model_create(c('bond_based'), model))
    call assert_ok(perion_model_set(model, c('youngs_modulus'), 1.0_c_double))
    call assert_ok(perion_model_set(model, c('horizon'), 3.015_c_double))
    call assert_refused(perion_simulation_create(points, model, simulation), &
        PERION_ERROR_ARGUMENT, "density")
    call assert(.not. c_associated(simulation), 'a refused call has made a simulation')
    call assert_ok(perion_model_destroy(model))
    call assert_ok(perion_points_destroy(points))
  end subroutine incomplete_model

  subroutine null_handles()
    type(c_ptr) :: simulation
    real(c_double) :: step

    simulation = c_null_ptr
    call assert_refused(perion_simulation_stable_time_step(simulation, step), PERION_ERROR_NULL, &
        "'simulation' is NULL")
    call assert_refused(perion_simulation_step(simulation, 1.0_c_double, 1_c_int64_t), &
        PERION_ERROR_NULL, "'simulation' is NULL")
    call assert_ok(perion_simulation_destroy(simulation))
  end subroutine null_handles

  subroutine materials_by_set()
    real(c_double) :: density(columns, rows)
    type(c_ptr) :: simulation, heavy

    simulation = c_null_ptr
    heavy = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call make_material(heavy, brittle=.false.)
    call assert_ok(perion_model_set(heavy, c('density'), 3.0_c_double))
    call assert_refused(perion_simulation_assign_model(simulation, c('lefft'), heavy), &
        PERION_ERROR_ARGUMENT, "'left'?")
    call assert_ok(perion_simulation_assign_model(simulation, c('left'), heavy))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_DENSITY, density, plate_count))
    call assert(all(same_bits(density(1, :), 3.0_c_double)), 'the left edge is not heavy')
    call assert(all(same_bits(density(2:, :), 1.0_c_double)), 'other points have become heavy')
    call assert_ok(perion_simulation_evaluate(simulation))
    call assert_refused(perion_simulation_assign_model(simulation, c('right'), heavy), &
        PERION_ERROR_STATE, 'set-up')
    call assert_ok(perion_model_destroy(heavy))
    call destroy(simulation)
  end subroutine materials_by_set

  subroutine weak_interface()
    real(c_double), parameter :: middle = columns / 2, width = columns, height = rows
    real(c_double), parameter :: weak = 1e-4_c_double
    integer(c_int64_t), allocatable :: pairs(:, :)
    real(c_double), allocatable :: integrity(:)
    integer(c_int64_t) :: count
    type(c_ptr) :: points, model, simulation

    points = c_null_ptr
    model = c_null_ptr
    simulation = c_null_ptr
    call make_plate_points(points)
    call assert_ok(perion_points_add_set_box(points, c('left half'), &
        [0.0_c_double, 0.0_c_double], [middle, height]))
    call assert_ok(perion_points_add_set_box(points, c('right half'), &
        [middle, 0.0_c_double], [width, height]))
    call make_material(model, brittle=.false.)
    call assert_ok(perion_simulation_create(points, model, simulation))
    call assert_refused(perion_simulation_set_interface(simulation, c('left half'), &
        c('right half'), -weak), PERION_ERROR_ARGUMENT, "'critical_energy_release_rate' is -")
    call assert_ok(perion_simulation_set_interface(simulation, c('left half'), c('right half'), weak))
    call pull(simulation)
    call make_steps(simulation, 40)

    call assert_ok(perion_simulation_bond_count(simulation, count))
    allocate (pairs(2, count), integrity(count))
    call assert_ok(perion_simulation_get_bonds(simulation, count, pairs, &
        integrity_or_null=integrity, count=count))
    call assert(any(integrity < 0.5_c_double), 'nothing has broken')
    call assert(all(across_middle(pairs) .or. integrity > 0.5_c_double), &
        'a bond beside the interface has broken')
    call destroy(simulation)
    call assert_ok(perion_model_destroy(model))
    call assert_ok(perion_points_destroy(points))
  end subroutine weak_interface

  subroutine forbidden_failure()
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call assert_refused(perion_simulation_forbid_failure(simulation, c('everything')), &
        PERION_ERROR_ARGUMENT, "'everything'")
    call assert_ok(perion_simulation_forbid_failure(simulation, c('all')))
    call pull(simulation)
    call make_steps(simulation, 40)
    call assert(broken_bonds(simulation) == 0, 'a bond has broken')
    call destroy(simulation)

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call assert(broken_bonds(simulation) > 0, 'without the ban nothing breaks either')
    call destroy(simulation)
  end subroutine forbidden_failure

  subroutine threads_change_nothing()
    ! Enough points to be shared out.
    integer, parameter :: factor = 3
    integer(c_int64_t), parameter :: length = 2 * factor**2 * plate_count
    real(c_double) :: displacement(length, 2)
    type(c_ptr) :: simulation
    integer(c_int32_t) :: threads

    do threads = 1, 2
      simulation = c_null_ptr
      call make_plate(simulation, brittle=.true., factor=factor)
      call assert_ok(perion_simulation_set_threads(simulation, 2 * threads - 1))
      call assert_refused(perion_simulation_set_threads(simulation, 0), PERION_ERROR_ARGUMENT, &
          "'threads' is 0")
      call pull(simulation)
      call make_steps(simulation, 40)
      call assert_ok(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, &
          displacement(:, threads), length))
      call assert(broken_bonds(simulation) > 0, 'nothing has broken')
      call destroy(simulation)
    end do
    call assert(all(same_bits(displacement(:, 1), displacement(:, 2))), &
        'one thread and three give different bits')
  end subroutine threads_change_nothing

end module setup_tests
