!> Conditions: constants, tables, functions of the host's, and values a point; and their end.
module conditions_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_conditions

  character(*), parameter :: file = 't500_conditions'

contains

  subroutine test_conditions()
    call run(file, 'a constant velocity on all points moves the body as a whole', constant_velocity)
    call run(file, 'a value an axis is a constant for each', constant_vector)
    call run(file, 'a table is linear between its times and constant outside', tables)
    call run(file, 'values are one a point, in the order of the set', values_a_point)
    call run(file, 'what is released moves freely again', release)
    call run(file, 'axes of 32 and of 64 bits are the same axes', wide_axes)
    call run(file, 'nonsense is refused and changes nothing', nonsense_is_refused)
  end subroutine test_conditions

  subroutine constant_velocity()
    real(c_double) :: displacement(2, plate_count), time
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.true.)
    call simulation%prescribe('all', PERION_QUANTITY_VELOCITY, 1, 0.5d0)
    call simulation%prescribe('all', PERION_QUANTITY_VELOCITY, 2, -0.25d0)
    call make_steps(simulation, 20)
    call simulation%time(time)
    call simulation%get(PERION_FIELD_DISPLACEMENT, displacement)
    ! Each of 20 sums may round once: 20 epsilon of at most 10.
    call assert(all(close_to(displacement(1, :), 0.5d0 * time, 5d-14)), &
        'the body is not at v t along the first axis')
    call assert(all(close_to(displacement(2, :), -0.25d0 * time, 5d-14)), &
        'the body is not at v t along the second axis')
    call assert(broken_bonds(simulation) == 0, 'bonds break in a body that moves as a whole')
    call simulation%destroy()
  end subroutine constant_velocity

  subroutine constant_vector()
    real(c_double), parameter :: values(3) = [0.02d0, 0d0, -0.01d0]
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    type(state) :: by_axis, at_once, before, after

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, 1, 0.02d0)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, 2, -0.01d0)
    call make_steps(simulation, 40)
    call take_state(simulation, by_axis)
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, values(::2), error)
    call assert_fine(error)
    call make_steps(simulation, 40)
    call take_state(simulation, at_once)
    call assert(same(by_axis, at_once), 'a value an axis is not what each axis has alone')

    ! Refused as a whole: the plate stays at rest.
    call make_plate(simulation, brittle=.true.)
    call take_state(simulation, before)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, values, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "perion_simulation_prescribe: 'values' has 3 numbers; there must be one for each of 2 axes")
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, [1d0, nan()], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'for axis 2 that is not finite')
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, [1d0, -infinity()], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'for axis 2 that is not finite')
    call simulation%prescribe('rihgt', PERION_QUANTITY_VELOCITY, values(:2), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'rihgt'")
    call simulation%prescribe('right', 7, values(:2), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'quantity' is 7")
    call make_steps(simulation, 1)
    call take_state(simulation, after)
    call assert(all(same_bits(before%displacement, after%displacement)), &
        'a refused condition has moved the body')
    call simulation%destroy()
  end subroutine constant_vector

  subroutine tables()
    real(c_double), parameter :: step = 0.125d0
    real(c_double), parameter :: expected(6) = [0.01d0, 0.01d0, 0.015d0, 0.02d0, 0.02d0, 0.02d0]
    real(c_double) :: at_left(2, rows)
    integer :: k
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe_table('left', PERION_QUANTITY_DISPLACEMENT, 1, [0.25d0, 0.5d0], &
        [0.01d0, 0.02d0])
    do k = 1, 6
      call simulation%step(step, 1)
      call simulation%get(PERION_FIELD_DISPLACEMENT, at_left, set='left')
      ! Times are exact; the interpolation rounds twice.
      call assert(all(close_to(at_left(1, :), expected(k), 1d-17)), &
          'the left edge is not where the table puts it')
    end do
    call simulation%destroy()
  end subroutine tables

  subroutine values_a_point()
    real(c_double) :: loads(rows), acceleration(2, plate_count)
    integer :: row
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    loads = [(0.001d0 * row, row = 1, rows)]
    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe_values('right', PERION_QUANTITY_BODY_FORCE, 2, loads(2:), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'count' is 8, but set 'right' has 9 points")
    call simulation%prescribe_values('right', PERION_QUANTITY_BODY_FORCE, 2, loads)
    loads = 0
    acceleration = -7
    call simulation%get(PERION_FIELD_ACCELERATION, acceleration, error=error)
    call assert_fails(error, PERION_ERROR_STATE, 'evaluate')
    call assert(all(same_bits(acceleration, -7d0)), 'a refused call has written its output')
    call simulation%evaluate()
    call simulation%get(PERION_FIELD_ACCELERATION, acceleration)
    do row = 1, rows
      ! Density is 1, and the undeformed body has no internal force.
      call assert(same_bits(acceleration(2, row * columns), 0.001d0 * row), &
          'a point is not accelerated by its own load')
      acceleration(:, row * columns) = 0
    end do
    call assert(all(abs(acceleration) <= 0), 'other points are loaded, or other axes')
    call simulation%destroy()
  end subroutine values_a_point

  subroutine release()
    real(c_double) :: before(2, rows), after(2, rows)
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call pull(simulation)
    call make_steps(simulation, 10)
    call simulation%get(PERION_FIELD_VELOCITY, before, 'left')
    call assert(all(same_bits(before(1, :), -0.02d0)), 'the left edge is not held')
    call simulation%release('left', PERION_QUANTITY_VELOCITY, 1)
    call make_steps(simulation, 10)
    call simulation%get(PERION_FIELD_VELOCITY, after, 'left')
    call assert(all(after(1, :) > before(1, :)), 'the body does not pull the released edge back')
    call simulation%release('left', PERION_QUANTITY_VELOCITY, 1, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "no velocity is prescribed on set 'left'")
    call simulation%destroy()
  end subroutine release

  subroutine wide_axes()
    real(c_double), parameter :: times(2) = [0d0, 1d0], values(2) = [0.01d0, 0.02d0]
    real(c_double) :: displacement(2, plate_count), load(2, rows)
    type(perion_simulation) :: simulation

    call make_plate(simulation, brittle=.false.)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, 1_int64, 0.5d0)
    call simulation%prescribe_table('left', PERION_QUANTITY_DISPLACEMENT, 2_int64, times, values)
    call simulation%prescribe_values('right', PERION_QUANTITY_BODY_FORCE, 2_int64, spread(3d0, 1, rows))
    call simulation%evaluate()
    call simulation%get(PERION_FIELD_BODY_FORCE, load, 'right')
    call assert(all(same_bits(load(2, :), 3d0)), 'the right edge is not loaded')
    call simulation%release('right', PERION_QUANTITY_BODY_FORCE, 2_int64)
    call simulation%step(0.5d0, 1_int64)
    call simulation%get(PERION_FIELD_DISPLACEMENT, displacement)
    call assert(all(same_bits(displacement(1, columns::columns), 0.25d0)), 'the right edge is not moved')
    call assert(all(close_to(displacement(2, 1::columns), 0.015d0, 1d-17)), 'the left edge is not moved')
    call simulation%evaluate()
    call simulation%get(PERION_FIELD_BODY_FORCE, load, 'right')
    call assert(all(abs(load) <= 0), 'what was released still loads')
    call simulation%destroy()
  end subroutine wide_axes

  subroutine nonsense_is_refused()
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error
    type(state) :: before, after

    call make_plate(simulation, brittle=.false.)
    call take_state(simulation, before)
    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 3, 0d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "perion_simulation_prescribe: 'axis' is 3; axes are 1 to 2")
    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 0, 0d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'axis' is 0")
    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 2_int64**32 + 1, 0d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'axis' is 4294967297")
    call simulation%prescribe('lefft', PERION_QUANTITY_VELOCITY, 1, 0d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'lefft'")
    call simulation%prescribe('left', 7, 1, 0d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'quantity' is 7")
    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 1, nan(), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'value' is NaN")
    call simulation%prescribe_table('left', PERION_QUANTITY_VELOCITY, 1, [1d0, 1d0], [0d0, 0d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'times must increase')
    call simulation%prescribe_table('left', PERION_QUANTITY_VELOCITY, 1, [1d0, 2d0], [0d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'times' has 2 numbers and 'values' 1")
    call simulation%prescribe_table('left', PERION_QUANTITY_VELOCITY, 9, [1d0, 2d0], [0d0, 0d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "prescribe_table: 'axis' is 9")
    call simulation%prescribe_values('left', PERION_QUANTITY_VELOCITY, -1, [0d0], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "prescribe_values: 'axis' is -1")
    call simulation%release('left', PERION_QUANTITY_VELOCITY, 3, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "release: 'axis' is 3")
    call make_steps(simulation, 1)
    call take_state(simulation, after)
    call assert(all(same_bits(before%displacement, after%displacement)), &
        'a refused condition has moved the body')
    call simulation%destroy()
  end subroutine nonsense_is_refused

end module conditions_tests
