!> Conditions: constants, tables, functions of the host's, and values a point; and their end.
module condition_tests
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_conditions

  character(*), parameter :: file = 'conditions.f90'

  !> What the functions below get and note.
  type :: shear
    real(c_double) :: rate = 0
    integer :: calls = 0, stop_at = huge(1)
    logical :: gives_infinity = .false.
    logical :: halting(size(ieee_usual)) = .false.
  end type shear

contains

  subroutine test_conditions()
    call run(file, 'a constant velocity on all points moves the body as a whole', constant_velocity)
    call run(file, 'a table is linear between its times and constant outside', tables)
    call run(file, 'a function sees places and time and fills values', functions)
    call run(file, 'a function that stops leaves the last completed step', function_stops)
    call run(file, 'a function that gives an infinite value is told', function_gives_infinity)
    call run(file, 'values are one a point, in the order of the set', values_a_point)
    call run(file, 'what is released moves freely again', release)
    call run(file, 'nonsense is refused', nonsense_is_refused)
  end subroutine test_conditions

  subroutine constant_velocity()
    real(c_double) :: displacement(2, plate_count), time
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call assert_ok(perion_simulation_prescribe(simulation, c('all'), PERION_QUANTITY_VELOCITY, 0, &
        0.5_c_double))
    call assert_ok(perion_simulation_prescribe(simulation, c('all'), PERION_QUANTITY_VELOCITY, 1, &
        -0.25_c_double))
    call make_steps(simulation, 20)
    call assert_ok(perion_simulation_time(simulation, time))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_DISPLACEMENT, displacement, &
        2 * plate_count))
    ! Each of 20 sums may round once: 20 epsilon of at most 10.
    call assert(all(close_to(displacement(1, :), 0.5_c_double * time, 5e-14_c_double)), &
        'the body is not at v t along x')
    call assert(all(close_to(displacement(2, :), -0.25_c_double * time, 5e-14_c_double)), &
        'the body is not at v t along y')
    call assert(broken_bonds(simulation) == 0, 'bonds break in a body that moves as a whole')
    call destroy(simulation)
  end subroutine constant_velocity

  subroutine tables()
    real(c_double), parameter :: step = 0.125_c_double
    real(c_double), parameter :: expected(6) = [0.01_c_double, 0.01_c_double, 0.015_c_double, &
        0.02_c_double, 0.02_c_double, 0.02_c_double]
    real(c_double) :: at_left(2, rows)
    integer :: k
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_prescribe_table(simulation, c('left'), &
        PERION_QUANTITY_DISPLACEMENT, 0, 2_c_int64_t, [0.25_c_double, 0.5_c_double], &
        [0.01_c_double, 0.02_c_double]))
    do k = 1, 6
      call assert_ok(perion_simulation_step(simulation, step, 1_c_int64_t))
      call assert_ok(perion_simulation_get_strided(simulation, c('left'), &
          PERION_FIELD_DISPLACEMENT, at_left, int(rows, c_int64_t), 2_c_int64_t))
      ! Times are exact; the interpolation rounds twice.
      call assert(all(close_to(at_left(1, :), expected(k), 1e-17_c_double)), &
          'the left edge is not where the table puts it')
    end do
    call destroy(simulation)
  end subroutine tables

  !> u_x = rate t y, a shear.
  function shear_displacement(user, time, count, reference_positions, values) &
      bind(c) result(stop_now)
    type(c_ptr), value :: user
    real(c_double), value :: time
    integer(c_int64_t), value :: count
    real(c_double), intent(in) :: reference_positions(*)
    real(c_double), intent(inout) :: values(*)
    integer(c_int) :: stop_now
    type(shear), pointer :: host
    integer(c_int64_t) :: k

    call c_f_pointer(user, host)
    host%calls = host%calls + 1
    call ieee_get_halting_mode(ieee_usual, host%halting)
    do k = 1, count
      values(k) = host%rate * time * reference_positions(2 * k)
    end do
    if (host%gives_infinity) values(3) = transfer(int(z'7ff0000000000000', c_int64_t), time)
    stop_now = merge(1, 0, host%calls >= host%stop_at)
  end function shear_displacement

  subroutine start_shear(simulation, host)
    type(c_ptr), intent(inout) :: simulation
    type(shear), target, intent(in) :: host

    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_prescribe_function(simulation, c('left'), &
        PERION_QUANTITY_DISPLACEMENT, 0, c_funloc(shear_displacement), c_loc(host)))
  end subroutine start_shear

  subroutine functions()
    real(c_double), parameter :: step = 0.125_c_double
    logical :: halting(size(ieee_usual))
    real(c_double) :: at_left(2, rows)
    integer :: row
    type(shear), target :: host
    type(c_ptr) :: simulation

    host%rate = 0.01_c_double
    simulation = c_null_ptr
    call start_shear(simulation, host)
    call assert_ok(perion_simulation_step(simulation, step, 4_c_int64_t))
    call assert(host%calls == 4, 'a displacement is not asked once a step')
    call assert_ok(perion_simulation_get_strided(simulation, c('left'), &
        PERION_FIELD_DISPLACEMENT, at_left, int(rows, c_int64_t), 2_c_int64_t))
    do row = 1, rows
      call assert(same_bits(at_left(1, row), host%rate * (4 * step) * (row - 0.5_c_double)), &
          'a point is not where the function puts it')
    end do
    call ieee_get_halting_mode(ieee_usual, halting)
    call assert(all(host%halting .eqv. halting), 'the function ran without the traps of its host')
    call destroy(simulation)
  end subroutine functions

  subroutine function_stops()
    integer(c_int64_t) :: steps
    type(shear), target :: host
    type(c_ptr) :: simulation

    host%stop_at = 3
    simulation = c_null_ptr
    call start_shear(simulation, host)
    call assert_refused(perion_simulation_step(simulation, 0.125_c_double, 9_c_int64_t), &
        PERION_ERROR_INTERRUPTED, "set 'left', axis 0, asked to stop at time 0.375")
    call assert_ok(perion_simulation_step_count(simulation, steps))
    call assert(steps == 2, 'the third step was not the one that stopped')
    call destroy(simulation)
  end subroutine function_stops

  subroutine function_gives_infinity()
    integer(c_int64_t) :: steps
    type(shear), target :: host
    type(c_ptr) :: simulation

    host%gives_infinity = .true.
    simulation = c_null_ptr
    call start_shear(simulation, host)
    call assert_refused(perion_simulation_step(simulation, 0.125_c_double, 9_c_int64_t), &
        PERION_ERROR_NUMERIC, 'inf for point 2 of the set')
    call assert_ok(perion_simulation_step_count(simulation, steps))
    call assert(steps == 0, 'a step was made')
    call destroy(simulation)
  end subroutine function_gives_infinity

  subroutine values_a_point()
    real(c_double) :: loads(rows), acceleration(2, columns, rows)
    integer :: row
    type(c_ptr) :: simulation

    loads = [(0.001_c_double * row, row = 1, rows)]
    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_refused(perion_simulation_prescribe_values(simulation, c('right'), &
        PERION_QUANTITY_BODY_FORCE, 1, int(rows - 1, c_int64_t), loads), PERION_ERROR_ARGUMENT, &
        "'count' is 8, but set 'right' has 9 points")
    call assert_ok(perion_simulation_prescribe_values(simulation, c('right'), &
        PERION_QUANTITY_BODY_FORCE, 1, int(rows, c_int64_t), loads))
    loads = 0
    call assert_refused(perion_simulation_get(simulation, PERION_FIELD_ACCELERATION, acceleration, &
        2 * plate_count), PERION_ERROR_STATE, 'evaluate')
    call assert_ok(perion_simulation_evaluate(simulation))
    call assert_ok(perion_simulation_get(simulation, PERION_FIELD_ACCELERATION, acceleration, &
        2 * plate_count))
    do row = 1, rows
      ! Density is 1, and the undeformed body has no internal force.
      call assert(same_bits(acceleration(2, columns, row), 0.001_c_double * row), &
          'a point is not accelerated by its own load')
    end do
    call assert(all(abs(acceleration(2, :columns - 1, :)) <= 0), 'other points are loaded')
    call destroy(simulation)
  end subroutine values_a_point

  subroutine release()
    real(c_double) :: before(2, rows), after(2, rows)
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call pull(simulation)
    call make_steps(simulation, 10)
    call velocity_at_left(simulation, before)
    call assert(all(same_bits(before(1, :), -0.02_c_double)), 'the left edge is not held')
    call assert_ok(perion_simulation_release(simulation, c('left'), PERION_QUANTITY_VELOCITY, 0))
    call make_steps(simulation, 10)
    call velocity_at_left(simulation, after)
    call assert(all(after(1, :) > before(1, :)), 'the body does not pull the released edge back')
    call assert_refused(perion_simulation_release(simulation, c('left'), &
        PERION_QUANTITY_VELOCITY, 0), PERION_ERROR_ARGUMENT, "no velocity is prescribed on set 'left'")
    call destroy(simulation)
  end subroutine release

  subroutine velocity_at_left(simulation, velocity)
    type(c_ptr), intent(in) :: simulation
    real(c_double), intent(inout) :: velocity(2, rows)

    call assert_ok(perion_simulation_get_strided(simulation, c('left'), PERION_FIELD_VELOCITY, &
        velocity, int(rows, c_int64_t), 2_c_int64_t))
  end subroutine velocity_at_left

  subroutine nonsense_is_refused()
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_refused(perion_simulation_prescribe(simulation, c('left'), &
        PERION_QUANTITY_VELOCITY, 2, 0.0_c_double), PERION_ERROR_ARGUMENT, "'axis' is 2")
    call assert_refused(perion_simulation_prescribe(simulation, c('left'), 7, 0, 0.0_c_double), &
        PERION_ERROR_ARGUMENT, "'quantity' is 7")
    call assert_refused(perion_simulation_prescribe_table(simulation, c('left'), &
        PERION_QUANTITY_VELOCITY, 0, 2_c_int64_t, [1.0_c_double, 1.0_c_double], &
        [0.0_c_double, 0.0_c_double]), PERION_ERROR_ARGUMENT, 'times must increase')
    call assert_refused(perion_simulation_prescribe_function(simulation, c('left'), &
        PERION_QUANTITY_VELOCITY, 0, c_null_funptr, c_null_ptr), PERION_ERROR_NULL, "'function'")
    call destroy(simulation)
  end subroutine nonsense_is_refused

end module condition_tests
