!> What every test uses: running, asserting, counting, and turning texts of C into texts of Fortran.
module testing
  use, intrinsic :: ieee_arithmetic
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion_c
  implicit none
  private
  public :: assert, assert_ok, assert_refused, c, close_to, finish, run, same_bits, text, to_text
  public :: temporary_directory

  !> Where tests may write files.
  character(:), allocatable :: temporary_directory

  character(:), allocatable :: current_file, current_test
  integer :: passed = 0, failed = 0, flaws = 0

  interface
    !> Of the C library: the length of a text.
    pure function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value, intent(in) :: text
      integer(c_size_t) :: strlen
    end function strlen
  end interface

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

  subroutine assert_ok(status)
    integer(c_int32_t), intent(in) :: status

    if (status == PERION_OK) return
    call assert(.false., text(perion_status_string(status)) // ': ' // text(perion_last_error()))
  end subroutine assert_ok

  !> The call was refused for the right reason: its text has these words in it.
  subroutine assert_refused(status, expected, words)
    integer(c_int32_t), intent(in) :: status, expected
    character(*), intent(in) :: words

    call assert(status == expected, 'expected ' // text(perion_status_string(expected)) // &
        ', not ' // text(perion_status_string(status)))
    call assert(index(text(perion_last_error()), words) > 0, &
        'no "' // words // '" in "' // text(perion_last_error()) // '"')
  end subroutine assert_refused

  !> A text as C takes it.
  pure function c(fortran)
    character(*), intent(in) :: fortran
    character(:, c_char), allocatable :: c

    c = fortran // c_null_char
  end function c

  !> A text of C as one of Fortran; "(null)" for none.
  function text(pointer)
    type(c_ptr), intent(in) :: pointer
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: place

    text = '(null)'
    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, letters, [strlen(pointer)])
    text = repeat(' ', size(letters))
    do place = 1, size(letters)
      text(place:place) = letters(place)
    end do
  end function text

  !> A text that C hands to a callback as an array of letters.
  function to_text(letters)
    character(kind=c_char), intent(in) :: letters(*)
    character(:), allocatable :: to_text
    integer :: length, place

    length = 0
    do while (letters(length + 1) /= c_null_char)
      length = length + 1
    end do
    to_text = repeat(' ', length)
    do place = 1, length
      to_text(place:place) = letters(place)
    end do
  end function to_text

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

end module testing
