!> What every test uses: running, asserting, counting.
module testing
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  implicit none
  private
  public :: assert, assert_fails, assert_fine, close_to, finish, infinity, nan, run, same_bits
  public :: temporary_directory

  !> Where tests may write files.
  character(:), allocatable :: temporary_directory

  character(:), allocatable :: current_file, current_test
  integer :: passed = 0, failed = 0, flaws = 0

contains

  !> Runs one test. Whatever it calls must leave the floating-point environment as it was.
  subroutine run(file, name, test)
    character(*), intent(in) :: file, name
    interface
      subroutine test()
      end subroutine test
    end interface
    logical, dimension(size(ieee_usual)) :: halting_before, halting_after, raised

    current_file = file
    current_test = name
    flaws = 0
    call ieee_get_halting_mode(ieee_usual, halting_before)
    call ieee_set_flag(ieee_usual, .false.)
    call test()
    call ieee_get_flag(ieee_usual, raised)
    call ieee_get_halting_mode(ieee_usual, halting_after)
    call assert(all(halting_before .eqv. halting_after), 'the traps have changed')
    call assert(.not. any(raised), 'floating-point exceptions have leaked to the host')
    if (flaws == 0) then
      passed = passed + 1
    else
      failed = failed + 1
    end if
  end subroutine run

  !> Prints the counts; the program ends badly when a test has failed.
  subroutine finish()
    print '(i0, a, i0, a)', passed, ' passed, ', failed, ' failed'
    if (failed > 0) stop 1, quiet=.true.
  end subroutine finish

  subroutine assert(holds, reason)
    logical, intent(in) :: holds
    character(*), intent(in) :: reason

    if (holds) return
    flaws = flaws + 1
    print '(6a)', current_file, ': ', current_test, ': ', reason
  end subroutine assert

  !> A call that was given an error has not failed.
  subroutine assert_fine(error)
    type(perion_error), allocatable, intent(in) :: error

    if (allocated(error)) call assert(.false., error%message)
  end subroutine assert_fine

  !> A call has failed for the right reason: its text has these words in it.
  subroutine assert_fails(error, status, words)
    type(perion_error), allocatable, intent(in) :: error
    integer(c_int32_t), intent(in) :: status
    character(*), intent(in) :: words

    call assert(allocated(error), 'a call that should fail with "' // words // '" has not')
    if (.not. allocated(error)) return
    call assert(error%status == status, 'expected ' // perion_status_string(status) // ', not ' // &
        perion_status_string(error%status) // ': ' // error%message)
    call assert(index(error%message, words) > 0, 'no "' // words // '" in "' // error%message // '"')
  end subroutine assert_fails

  !> Equal to the last bit; plus and minus zero differ.
  elemental function same_bits(one, other)
    real(c_double), intent(in) :: one, other
    logical :: same_bits

    same_bits = transfer(one, 0_int64) == transfer(other, 0_int64)
  end function same_bits

  elemental function close_to(value, expected, tolerance)
    real(c_double), intent(in) :: value, expected, tolerance
    logical :: close_to

    close_to = abs(value - expected) <= tolerance
  end function close_to

  function infinity()
    real(c_double) :: infinity

    infinity = transfer(int(z'7ff0000000000000', int64), infinity)
  end function infinity

  function nan()
    real(c_double) :: nan

    nan = transfer(int(z'7ff8000000000000', int64), nan)
  end function nan

end module testing
