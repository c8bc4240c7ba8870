!> Set-up of a simulation: materials by set, interfaces, what may not fail, and threads.
module setup_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_setup

  character(*), parameter :: file = 't400_setup'

contains

  subroutine test_setup()
    call run(file, 'a model that lacks its density makes no simulation', incomplete_model)
    call run(file, 'what was not created is refused', not_created)
    call run(file, 'a set gets a material of its own until set-up ends', materials_by_set)
    call run(file, 'a weak interface breaks, and nothing else', weak_interface)
    call run(file, 'bonds that may not fail stay', forbidden_failure)
    call run(file, 'the number of threads changes no bit', threads_change_nothing)
  end subroutine test_setup

  subroutine incomplete_model()
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    real(c_double) :: time

    call make_points(points)
    call model%create('bond_based')
    call model%set('youngs_modulus', 1d0)
    call model%set('horizon', 3.015d0)
    call simulation%create(points, model, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'density')
    call simulation%time(time, error)
    call assert_fails(error, PERION_ERROR_NULL, 'the perion_simulation has not been created')
    ! Nor does it take the place of one that is there.
    call make_plate(simulation, brittle=.false.)
    call simulation%set_time(2d0)
    call simulation%create(points, model, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'density')
    call simulation%time(time)
    call assert(same_bits(time, 2d0), 'a refused creation has changed the simulation')
    call model%set('density', 1d0)
    call simulation%create(points, model)
    call simulation%time(time)
    call assert(same_bits(time, 0d0), 'the old simulation is still there')
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine incomplete_model

  subroutine not_created()
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    real(c_double) :: values(2, 1)
    integer :: pairs(2, 1)

    call simulation%create(points, model, error)
    call assert_fails(error, PERION_ERROR_NULL, &
        'perion_simulation_create: the perion_points has not been created')
    call make_points(points)
    call simulation%create(points, model, error)
    call assert_fails(error, PERION_ERROR_NULL, &
        'perion_simulation_create: the perion_model has not been created')
    call simulation%step(1d0, 1, error)
    call assert_fails(error, PERION_ERROR_NULL, &
        'perion_simulation_step: the perion_simulation has not been created')
    call simulation%assign_model('all', model, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_assign_model')
    call simulation%get(PERION_FIELD_VELOCITY, values, error=error)
    call assert_fails(error, PERION_ERROR_NULL, &
        'perion_simulation_get: the perion_simulation has not been created')
    values = 0
    call simulation%set(PERION_FIELD_VELOCITY, values, error=error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_set')
    call simulation%sum(PERION_FIELD_VELOCITY, values(:, 1), error=error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_sum')
    pairs = 1
    call simulation%break_bonds(pairs, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_break_bonds')
    call simulation%get_bonds(pairs, error=error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_get_bonds')
    call simulation%get_bonds(error=error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_get_bonds')
    call simulation%break_crossing(values, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_break_crossing')
    call simulation%prescribe('all', PERION_QUANTITY_VELOCITY, 1, 0d0, error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_prescribe')
    call simulation%prescribe('all', PERION_QUANTITY_VELOCITY, [0d0, 0d0], error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_prescribe')
    call simulation%set_progress(error=error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_set_progress')
    call simulation%set_log(error=error)
    call assert_fails(error, PERION_ERROR_NULL, 'perion_simulation_set_log')
    call simulation%destroy()
    call points%destroy()
  end subroutine not_created

  subroutine materials_by_set()
    real(c_double) :: density(plate_count)
    type(perion_simulation) :: simulation
    type(perion_model) :: heavy
    type(perion_error), allocatable :: error
    logical :: at_left(plate_count)
    integer :: k

    call make_plate(simulation, brittle=.false.)
    call make_model(heavy, brittle=.false.)
    call heavy%set('density', 3d0)
    call simulation%assign_model('lefft', heavy, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'left'?")
    call simulation%assign_model('left', heavy)
    call simulation%get(PERION_FIELD_DENSITY, density)
    at_left = [(mod(k, columns) == 1, k = 1, plate_count)]
    call assert(all(same_bits(density, merge(3d0, 1d0, at_left))), &
        'the left edge is not heavy, or other points are')
    call simulation%evaluate()
    call simulation%assign_model('right', heavy, error)
    call assert_fails(error, PERION_ERROR_STATE, 'set-up')
    call simulation%set_interface('left', 'right', 1d0, error)
    call assert_fails(error, PERION_ERROR_STATE, 'set-up')
    call heavy%destroy()
    call simulation%destroy()
  end subroutine materials_by_set

  subroutine weak_interface()
    real(c_double), parameter :: middle = columns / 2, width = columns, height = rows
    real(c_double), parameter :: weak = 1d-4
    integer, allocatable :: pairs(:, :)
    real(c_double), allocatable :: integrity(:)
    integer :: count
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_points(points)
    call points%add_set_box('left half', [0d0, 0d0], [middle, height])
    call points%add_set_box('right half', [middle, 0d0], [width, height])
    call make_model(model, brittle=.false.)
    call simulation%create(points, model)
    call simulation%set_interface('left half', 'right half', -weak, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'critical_energy_release_rate' is -")
    call simulation%set_interface('left half', 'third half', weak, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'third half'")
    call simulation%set_interface('left half', 'right half', weak)
    call pull(simulation)
    call make_steps(simulation, 40)
    call simulation%bond_count(count)
    allocate (pairs(2, count), integrity(count))
    call simulation%get_bonds(pairs, integrity=integrity)
    call assert(any(integrity < 0.5d0), 'nothing has broken')
    call assert(all(across_middle(pairs) .or. integrity > 0.5d0), &
        'a bond beside the interface has broken')
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine weak_interface

  subroutine forbidden_failure()
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.true.)
    call simulation%forbid_failure('everything', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'everything'")
    call simulation%forbid_failure('all')
    call pull(simulation)
    call make_steps(simulation, 40)
    call assert(broken_bonds(simulation) == 0, 'a bond has broken')

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call make_steps(simulation, 40)
    call assert(broken_bonds(simulation) > 0, 'without the ban nothing breaks either')
    call simulation%destroy()
  end subroutine forbidden_failure

  subroutine threads_change_nothing()
    ! Enough points to be shared out.
    integer, parameter :: factor = 3
    real(c_double) :: displacement(2, factor**2 * plate_count, 2)
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.true., factor=factor)
    call simulation%set_threads(1)
    call tear(1)
    call make_plate(simulation, brittle=.true., factor=factor)
    call simulation%set_threads(3_int64)
    call simulation%set_threads(0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'threads' is 0")
    call simulation%set_threads(2_int64**32 + 1, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'threads'")
    call tear(2)
    call assert(all(same_bits(displacement(:, :, 1), displacement(:, :, 2))), &
        'one thread and three give different bits')
    call simulation%destroy()
  contains
    subroutine tear(turn)
      integer, intent(in) :: turn

      call pull(simulation)
      call make_steps(simulation, 40)
      call simulation%get(PERION_FIELD_DISPLACEMENT, displacement(:, :, turn))
      call assert(broken_bonds(simulation) > 0, 'nothing has broken')
    end subroutine tear
  end subroutine threads_change_nothing

end module setup_tests
