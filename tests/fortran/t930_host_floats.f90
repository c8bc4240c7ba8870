!> A host with an unusual floating-point environment: rounding upward, subnormal numbers flushed to
!> zero, flags up. Results have the bits of the default environment, and calls leave it as it was.
!> Traps are set in all tests.
module host_floats_tests
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_c_binding
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_host_floats

  character(*), parameter :: file = 't930_host_floats'

contains

  subroutine test_host_floats()
    call run(file, 'results do not depend on how the host rounds', rounding)
    call run(file, 'flags of the host stay as they were', flags)
    call run(file, 'a body that is torn to infinity fires no trap', infinity_inside)
  end subroutine test_host_floats

  subroutine rounding()
    type(ieee_round_type) :: host_rounding, after
    type(perion_simulation) :: simulation
    type(state) :: wanted, got
    logical :: gradual

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call simulation%step(0.125d0, 40)
    call take_state(simulation, wanted)

    call ieee_get_rounding_mode(host_rounding)
    call ieee_get_underflow_mode(gradual)
    call ieee_set_rounding_mode(ieee_up)
    call ieee_set_underflow_mode(.false.)
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    call simulation%step(0.125d0, 40)
    call take_state(simulation, got)
    call ieee_get_rounding_mode(after)
    call assert(after == ieee_up, 'the rounding of the host has changed')
    call ieee_set_underflow_mode(gradual)
    call ieee_set_rounding_mode(host_rounding)
    call assert(same(wanted, got), 'the results have other bits')
    call simulation%destroy()
  end subroutine rounding

  subroutine flags()
    logical, dimension(size(ieee_all)) :: before, raised, after
    type(perion_simulation) :: simulation

    call ieee_get_flag(ieee_all, before)
    call ieee_set_flag(ieee_inexact, .true.)
    call ieee_set_flag(ieee_underflow, .true.)
    call ieee_get_flag(ieee_all, raised)
    call make_plate(simulation, brittle=.true.)
    call simulation%evaluate()
    call ieee_get_flag(ieee_all, after)
    call assert(all(raised .eqv. after), 'the flags have changed')
    call ieee_set_flag(ieee_all, before)
    call simulation%destroy()
  end subroutine flags

  subroutine infinity_inside()
    real(c_double) :: velocity(2, plate_count)
    integer :: steps
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.true.)
    velocity(:, ::2) = 1d300
    velocity(:, 2::2) = -1d300
    call simulation%set(PERION_FIELD_VELOCITY, velocity)
    call simulation%step(0.125d0, 3, error)
    call assert_fails(error, PERION_ERROR_NUMERIC, 'too large to step from')
    call simulation%step_count(steps)
    call assert(steps < 3, 'a motion without end is a step')
    call simulation%destroy()
  end subroutine infinity_inside

end module host_floats_tests
