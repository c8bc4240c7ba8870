!> The bodies that the tests work on, in units in which spacing, density and Young's modulus are 1: then
!> waves run about one spacing in a unit of time.
module scenes
  use, intrinsic :: iso_c_binding
  use perion_c
  use testing, only: assert_ok, c
  implicit none
  private
  public :: broken_bonds, columns, destroy, make_material, make_plate, make_plate_points, make_steps
  public :: plate_count, pull, rows

  integer, parameter :: columns = 16, rows = 9
  integer(c_int64_t), parameter :: plate_count = columns * rows

  real(c_double), parameter :: critical_stretch = 0.02_c_double

contains

  !> A plate of columns x rows points, x fastest, its corner in the origin; its first and last column
  !> are the sets "left" and "right".
  subroutine make_plate_points(points)
    type(c_ptr), intent(inout) :: points
    real(c_double), parameter :: width = columns, height = rows

    call assert_ok(perion_points_create_block(2, [0.0_c_double, 0.0_c_double], [width, height], &
        1.0_c_double, points))
    call assert_ok(perion_points_add_set_box(points, c('left'), [0.0_c_double, 0.0_c_double], &
        [1.0_c_double, height]))
    call assert_ok(perion_points_add_set_box(points, c('right'), &
        [width - 1.0_c_double, 0.0_c_double], [width, height]))
  end subroutine make_plate_points

  !> A material whose bonds break at a stretch of 0.02 when it is `brittle`.
  subroutine make_material(model, brittle)
    type(c_ptr), intent(inout) :: model
    logical, intent(in) :: brittle

    call assert_ok(perion_model_create(c('bond_based'), model))
    call assert_ok(perion_model_set(model, c('density'), 1.0_c_double))
    call assert_ok(perion_model_set(model, c('youngs_modulus'), 1.0_c_double))
    call assert_ok(perion_model_set(model, c('horizon'), 3.015_c_double))
    if (brittle) call assert_ok(perion_model_set(model, c('critical_stretch'), critical_stretch))
  end subroutine make_material

  subroutine make_plate(simulation, brittle)
    type(c_ptr), intent(inout) :: simulation
    logical, intent(in) :: brittle
    type(c_ptr) :: points, model

    points = c_null_ptr
    model = c_null_ptr
    call make_plate_points(points)
    call make_material(model, brittle)
    call assert_ok(perion_simulation_create(points, model, simulation))
    call assert_ok(perion_points_destroy(points))
    call assert_ok(perion_model_destroy(model))
  end subroutine make_plate

  !> Pulls the left and right edge of a plate apart, fast enough to tear a brittle one in 40 steps.
  subroutine pull(simulation)
    type(c_ptr), intent(in) :: simulation

    call assert_ok(perion_simulation_prescribe(simulation, c('left'), &
        PERION_QUANTITY_VELOCITY, 0, -0.02_c_double))
    call assert_ok(perion_simulation_prescribe(simulation, c('right'), &
        PERION_QUANTITY_VELOCITY, 0, 0.02_c_double))
  end subroutine pull

  !> Steps as long as is known to be stable.
  subroutine make_steps(simulation, steps)
    type(c_ptr), intent(in) :: simulation
    integer, intent(in) :: steps
    real(c_double) :: time_step

    call assert_ok(perion_simulation_stable_time_step(simulation, time_step))
    call assert_ok(perion_simulation_step(simulation, time_step, int(steps, c_int64_t)))
  end subroutine make_steps

  function broken_bonds(simulation)
    type(c_ptr), intent(in) :: simulation
    integer(c_int64_t) :: broken_bonds
    type(perion_health) :: health

    call perion_health_init(health)
    call assert_ok(perion_simulation_health(simulation, health))
    broken_bonds = health%broken_bonds
  end function broken_bonds

  subroutine destroy(simulation)
    type(c_ptr), intent(inout) :: simulation

    call assert_ok(perion_simulation_destroy(simulation))
  end subroutine destroy

end module scenes
