!> The bodies that the tests work on, in units in which spacing, density and Young's modulus are 1: then
!> waves run about one spacing in a unit of time.
module scenes
  use, intrinsic :: iso_c_binding
  use perion_c
  use testing, only: assert_ok, c
  implicit none
  private
  public :: across_middle, broken_bonds, columns, destroy, make_material, make_plate, make_plate_points
  public :: make_steps, plate_count, pull, rows

  integer, parameter :: columns = 16, rows = 9
  integer(c_int64_t), parameter :: plate_count = columns * rows

  real(c_double), parameter :: critical_stretch = 0.02_c_double

contains

  !> A plate of columns x rows points, x fastest, its corner in the origin; its first and last column
  !> are the sets "left" and "right". A `factor` gives it that many times the columns and rows.
  subroutine make_plate_points(points, factor)
    type(c_ptr), intent(inout) :: points
    integer, optional, intent(in) :: factor
    real(c_double) :: width, height

    width = columns
    height = rows
    if (present(factor)) then
      width = factor * width
      height = factor * height
    end if
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

  subroutine make_plate(simulation, brittle, factor)
    type(c_ptr), intent(inout) :: simulation
    logical, intent(in) :: brittle
    integer, optional, intent(in) :: factor
    type(c_ptr) :: points, model

    points = c_null_ptr
    model = c_null_ptr
    call make_plate_points(points, factor)
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

    call perion_health_init(health, c_sizeof(health))
    call assert_ok(perion_simulation_health(simulation, health))
    broken_bonds = health%broken_bonds
  end function broken_bonds

  !> Which of these pairs of points (from 0) have one in the left and one in the right half.
  function across_middle(pairs)
    integer(c_int64_t), intent(in) :: pairs(:, :)
    logical :: across_middle(size(pairs, 2)), left(2)
    integer :: k

    do k = 1, size(pairs, 2)
      left = mod(pairs(:, k), int(columns, c_int64_t)) < columns / 2
      across_middle(k) = left(1) .neqv. left(2)
    end do
  end function across_middle

  subroutine destroy(simulation)
    type(c_ptr), intent(inout) :: simulation

    call assert_ok(perion_simulation_destroy(simulation))
  end subroutine destroy

end module scenes
