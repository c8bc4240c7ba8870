!> What the module `perion` is made with: failures, and text, indices and arrays on their way to C
!> and back. Programs use `perion`.
module perion_support
  use, intrinsic :: iso_c_binding
  use perion_c, only: perion_last_error, PERION_ERROR_ARGUMENT, PERION_ERROR_MEMORY, &
      PERION_ERROR_NULL, PERION_OK
  implicit none
  private
  public :: perion_error
  public :: c_text, check, f_text, from_one, in_place, is_live, lined_up, narrow, number, ok, refuse
  public :: refuse_assignment, room, shape_text, told

  !> Why a call has failed.
  type :: perion_error
    !> PERION_ERROR_ARGUMENT and so on.
    integer(c_int32_t) :: status = PERION_OK
    !> The call, the argument, what was given, what is allowed, what to do.
    character(:), allocatable :: message
  end type perion_error

  !> Where C finds the numbers of an array without a copy, and how many it goes on by from one
  !> column to the next; null where it cannot.
  interface in_place
    module procedure matrix_in_place, vector_in_place
  end interface in_place

  interface
    !> Of the C library: the length of a text.
    pure function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value, intent(in) :: text
      integer(c_size_t) :: strlen
    end function strlen
  end interface

contains

  !> Tells a failure of the library, or ends the program with it where nobody listens.
  recursive subroutine check(status, error)
    integer(c_int32_t), intent(in) :: status
    type(perion_error), allocatable, optional, intent(inout) :: error

    if (status /= PERION_OK) call refuse(status, told(f_text(perion_last_error())), error)
  end subroutine check

  !> The same, for calls that go on after a success.
  recursive function ok(status, error)
    integer(c_int32_t), intent(in) :: status
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: ok

    ok = status == PERION_OK
    call check(status, error)
  end function ok

  !> A text of the library as this module tells it: a handle that is null is an object that has not
  !> been created, and what counts from 0 is said to.
  pure recursive function told(text) result(words)
    character(*), intent(in) :: text
    character(:), allocatable :: words
    character(*), parameter :: objects(*) = [character(10) :: 'points', 'model', 'simulation']
    character(*), parameter :: counted(*) = [character(6) :: 'point', 'points', 'axis', 'vertex']
    character(:), allocatable :: null
    integer :: k, at

    words = text
    do k = 1, size(objects)
      null = 'argument ''' // trim(objects(k)) // ''' is NULL'
      at = index(words, null)
      if (at > 0) words = words(:at - 1) // not_created(trim(objects(k))) // words(at + len(null):)
    end do
    if (has_number(text, '''[') .or. any([(has_number(text, trim(counted(k)) // ' '), &
        k = 1, size(counted))])) words = words // ' (points and axes in this text count from 0)'
  end function told

  !> Whether a word in a text has a number after it.
  pure recursive function has_number(text, word)
    character(*), intent(in) :: text, word
    logical :: has_number
    integer :: at, next

    has_number = .false.
    next = 1
    do
      at = index(text(next:), word)
      if (at == 0) return
      next = next + at - 1 + len(word)
      if (next > len(text)) return
      has_number = scan(text(next:next), '0123456789') > 0
      if (has_number) return
    end do
  end function has_number

  pure recursive function not_created(object) result(text)
    character(*), intent(in) :: object
    character(:), allocatable :: text

    text = 'the perion_' // object // ' has not been created'
  end function not_created

  recursive subroutine refuse(status, message, error)
    integer(c_int32_t), intent(in) :: status
    character(*), intent(in) :: message
    type(perion_error), allocatable, optional, intent(inout) :: error

    if (.not. present(error)) error stop message
    allocate (error)
    error%status = status
    error%message = message
  end subroutine refuse

  !> Ends the program: two objects with one handle would free it twice. Where neither has one there
  !> is nothing to copy.
  recursive subroutine refuse_assignment(what, left_is_live, right_is_live)
    character(*), intent(in) :: what
    logical, intent(in) :: left_is_live, right_is_live
    character(*), parameter :: rule = ' cannot be assigned, since handles do not copy; '

    if (right_is_live) error stop what // rule // 'pass the object itself, or create another'
    if (left_is_live) error stop what // rule // 'call destroy to free the one on the left'
  end subroutine refuse_assignment

  !> Whether there is an object, which calls that check shapes ask first.
  recursive function is_live(handle, call, error)
    type(c_ptr), intent(in) :: handle
    character(*), intent(in) :: call
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: is_live

    integer :: ahead, length

    is_live = c_associated(handle)
    if (is_live) return
    ! The second word of the call's name is that of the object.
    ahead = index(call, '_')
    length = index(call(ahead + 1:), '_') - 1
    call refuse(PERION_ERROR_NULL, call // ': ' // not_created(call(ahead + 1:ahead + length)), error)
  end function is_live

  !> Whether an array for copies has been allocated.
  recursive function room(flaw, call, error)
    integer, intent(in) :: flaw
    character(*), intent(in) :: call
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: room

    room = flaw == 0
    if (.not. room) call refuse(PERION_ERROR_MEMORY, call // ': no memory for a copy', error)
  end function room

  !> A number that C counts with as one of 32 bits, where it fits.
  recursive subroutine narrow(call, wide, value, error)
    character(*), intent(in) :: call
    integer(c_int64_t), intent(in) :: wide
    integer(c_int32_t), intent(inout) :: value
    type(perion_error), allocatable, optional, intent(inout) :: error

    if (wide > huge(value)) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ' // number(wide) // &
          ' does not fit into an integer of 32 bits; use one of 64', error)
    else
      value = int(wide, c_int32_t)
    end if
  end subroutine narrow

  !> A number in digits.
  pure recursive function number(value) result(digits)
    integer(c_int64_t), intent(in) :: value
    character(:), allocatable :: digits
    character(20) :: buffer

    write (buffer, '(i0)') value
    digits = trim(buffer)
  end function number

  !> A shape as Fortran writes it.
  pure recursive function shape_text(extents) result(text)
    integer(c_int64_t), intent(in) :: extents(:)
    character(:), allocatable :: text
    integer :: place

    text = '(' // number(extents(1))
    do place = 2, size(extents)
      text = text // ',' // number(extents(place))
    end do
    text = text // ')'
  end function shape_text

  !> A text as C takes it.
  pure recursive function c_text(text)
    character(*), intent(in) :: text
    character(:, c_char), allocatable :: c_text

    c_text = trim(text) // c_null_char
  end function c_text

  !> A text of C; '' for none.
  recursive function f_text(pointer) result(text)
    type(c_ptr), intent(in) :: pointer
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: place

    text = ''
    if (.not. c_associated(pointer)) return
    call c_f_pointer(pointer, letters, [strlen(pointer)])
    text = repeat(' ', size(letters))
    do place = 1, size(letters)
      text(place:place) = letters(place)
    end do
  end function f_text

  !> Makes places that count from 0 of indices that count from 1, where none is out of range.
  recursive function from_one(call, name, length, indices, count, error)
    character(*), intent(in) :: call, name
    integer(c_int64_t), intent(in) :: length, count
    integer(c_int64_t), intent(inout) :: indices(length)
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: from_one
    integer(c_int64_t) :: k

    do k = 1, length
      from_one = indices(k) >= 1 .and. indices(k) <= count
      if (from_one) cycle
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''' // name // ''' names point ' // &
          number(indices(k)) // '; points are 1 to ' // number(count), error)
      return
    end do
    indices(:) = indices - 1
    from_one = .true.
  end function from_one

  !> Whether the numbers of an array are there one after another: `start` is where they are, or a copy
  !> of them on the heap. Copies that compilers make may go to the stack, too small for many points.
  recursive function lined_up(array, copy, start, call, error)
    real(c_double), target, intent(in) :: array(:)
    real(c_double), allocatable, target, intent(out) :: copy(:)
    real(c_double), pointer, contiguous, intent(out) :: start(:)
    character(*), intent(in) :: call
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: lined_up
    integer(c_int64_t) :: stride, place
    integer :: flaw

    lined_up = .true.
    call in_place(array, start, stride)
    if (associated(start) .and. stride == 1) return
    allocate (copy(size(array, kind=c_int64_t)), stat=flaw)
    lined_up = room(flaw, call, error)
    if (.not. lined_up) return
    do place = 1, size(array, kind=c_int64_t)
      copy(place) = array(place)
    end do
    start => copy
  end function lined_up

  recursive subroutine matrix_in_place(array, start, stride)
    real(c_double), target :: array(:, :)
    real(c_double), pointer, contiguous, intent(out) :: start(:)
    integer(c_int64_t), intent(out) :: stride
    integer(c_int64_t) :: rows, columns

    rows = size(array, 1, c_int64_t)
    columns = size(array, 2, c_int64_t)
    start => null()
    stride = rows
    if (rows < 1 .or. columns < 1) return
    if (rows > 1) then
      if (distance(array(1, 1), array(2, 1)) /= 1) return
    end if
    if (columns > 1) stride = distance(array(1, 1), array(1, 2))
    if (stride < rows) return
    call c_f_pointer(c_loc(array(1, 1)), start, [(columns - 1) * stride + rows])
  end subroutine matrix_in_place

  recursive subroutine vector_in_place(array, start, stride)
    real(c_double), target :: array(:)
    real(c_double), pointer, contiguous, intent(out) :: start(:)
    integer(c_int64_t), intent(out) :: stride
    integer(c_int64_t) :: count

    count = size(array, kind=c_int64_t)
    start => null()
    stride = 1
    if (count < 1) return
    if (count > 1) stride = distance(array(1), array(2))
    if (stride < 1) return
    call c_f_pointer(c_loc(array(1)), start, [(count - 1) * stride + 1])
  end subroutine vector_in_place

  !> How many numbers one lies behind another; 0 when it is not a whole number of them.
  recursive function distance(one, other)
    real(c_double), target :: one, other
    integer(c_int64_t) :: distance
    integer(c_int64_t), parameter :: bytes_each = storage_size(0.0_c_double) / 8
    integer(c_intptr_t) :: bytes

    bytes = transfer(c_loc(other), bytes) - transfer(c_loc(one), bytes)
    distance = 0
    if (mod(bytes, int(bytes_each, c_intptr_t)) == 0) distance = bytes / bytes_each
  end function distance

end module perion_support
