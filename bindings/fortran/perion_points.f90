!> Points: made, given horizons and sets, asked, destroyed.
submodule (perion) points_procedures
  use perion_c, only: perion_points_add_set, perion_points_add_set_box, perion_points_count, &
      perion_points_create, perion_points_create_block, perion_points_destroy, &
      perion_points_dimension, perion_points_get_coordinates, perion_points_get_set, &
      perion_points_get_set_name, perion_points_get_volumes, perion_points_read, &
      perion_points_set_count, perion_points_set_horizons, perion_points_set_size
  use perion_support
  use, intrinsic :: iso_c_binding, only: c_associated, c_bool, c_char, c_loc
  implicit none

contains

  module procedure points_create
    character(*), parameter :: call = 'perion_points_create'
    real(c_double), pointer, contiguous :: start(:), each(:)
    real(c_double), allocatable :: packed(:, :)
    real(c_double), allocatable, target :: copy(:)
    integer(c_int64_t) :: count, stride
    integer(c_int32_t) :: dimension
    type(c_ptr) :: fresh
    integer :: flaw

    count = size(coordinates, 2, c_int64_t)
    dimension = size(coordinates, 1, c_int32_t)
    if (.not. any(dimension == [2, 3]) .and. any(count == [2, 3])) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''coordinates'' has the shape ' // &
          shape_text(shape(coordinates, c_int64_t)) // &
          '; it must be (dimension,count) - transposed?', error)
      return
    end if
    if (size(volumes, kind=c_int64_t) /= count) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''volumes'' has ' // &
          number(size(volumes, kind=c_int64_t)) // ' numbers for ' // number(count) // &
          ' points; coordinates are (dimension,count), volumes (count)', error)
      return
    end if
    if (.not. lined_up(volumes, copy, each, call, error)) return
    fresh = c_null_ptr
    call in_place(coordinates, start, stride)
    if (associated(start)) then
      if (.not. ok(perion_points_create(dimension, count, start, stride, each, fresh), error)) return
    else
      allocate (packed(dimension, count), stat=flaw)
      if (.not. room(flaw, call, error)) return
      packed(:, :) = coordinates
      if (.not. ok(perion_points_create(dimension, count, packed, int(dimension, c_int64_t), &
          each, fresh), error)) return
    end if
    call replace(self, fresh, error)
  end procedure points_create

  module procedure points_create_block
    type(c_ptr) :: fresh

    if (size(lower) /= size(upper)) then
      call refuse(PERION_ERROR_ARGUMENT, 'perion_points_create_block: ''lower'' has ' // &
          number(size(lower, kind=c_int64_t)) // ' numbers and ''upper'' ' // &
          number(size(upper, kind=c_int64_t)) // '; both need one an axis', error)
      return
    end if
    fresh = c_null_ptr
    if (ok(perion_points_create_block(size(lower, kind=c_int32_t), lower, upper, spacing, fresh), &
        error)) call replace(self, fresh, error)
  end procedure points_create_block

  module procedure points_read
    type(c_ptr) :: fresh

    fresh = c_null_ptr
    if (ok(perion_points_read(c_text(path), fresh), error)) call replace(self, fresh, error)
  end procedure points_read

  !> Puts new points in the place of old ones, or frees the new ones where the old ones cannot go.
  recursive subroutine replace(self, fresh, error)
    class(perion_points), intent(inout) :: self
    type(c_ptr), intent(inout) :: fresh
    type(perion_error), allocatable, optional, intent(inout) :: error
    integer(c_int32_t) :: status

    status = perion_points_destroy(self%handle)
    if (status == PERION_OK) then
      self%handle = fresh
    else
      call check(status, error)
      status = perion_points_destroy(fresh)
    end if
  end subroutine replace

  module procedure points_set_horizons
    character(*), parameter :: call = 'perion_points_set_horizons'
    real(c_double), allocatable, target :: copy(:)
    real(c_double), pointer, contiguous :: each(:)

    if (lined_up(horizons, copy, each, call, error)) call check(perion_points_set_horizons( &
        self%handle, size(horizons, kind=c_int64_t), each), error)
  end procedure points_set_horizons

  module procedure points_add_set_int64
    integer(c_int64_t), allocatable :: places(:)
    integer :: flaw

    allocate (places(size(indices, kind=c_int64_t)), stat=flaw)
    if (.not. room(flaw, 'perion_points_add_set', error)) return
    places(:) = indices
    call add_set(self, name, places, error)
  end procedure points_add_set_int64

  module procedure points_add_set_int32
    integer(c_int64_t), allocatable :: places(:)
    integer :: flaw

    allocate (places(size(indices, kind=c_int64_t)), stat=flaw)
    if (.not. room(flaw, 'perion_points_add_set', error)) return
    places(:) = indices
    call add_set(self, name, places, error)
  end procedure points_add_set_int32

  !> Names a set by indices, which become the library's.
  recursive subroutine add_set(self, name, indices, error)
    class(perion_points), intent(in) :: self
    character(*), intent(in) :: name
    integer(c_int64_t), allocatable, intent(inout) :: indices(:)
    type(perion_error), allocatable, optional, intent(inout) :: error
    character(*), parameter :: call = 'perion_points_add_set'
    logical(c_bool), allocatable :: is_given(:)
    integer(c_int64_t) :: length, count, k
    integer :: flaw

    if (.not. is_live(self%handle, call, error)) return
    if (.not. ok(perion_points_count(self%handle, count), error)) return
    length = size(indices, kind=c_int64_t)
    if (.not. from_one(call, 'indices', length, indices, count, error)) return
    ! The library finds this too, but counts from 0.
    allocate (is_given(0:count - 1), stat=flaw)
    if (.not. room(flaw, call, error)) return
    is_given(:) = .false._c_bool
    do k = 1, length
      if (is_given(indices(k))) then
        call refuse(PERION_ERROR_ARGUMENT, call // ': ''indices'' names point ' // &
            number(indices(k) + 1) // ' twice', error)
        return
      end if
      is_given(indices(k)) = .true._c_bool
    end do
    call check(perion_points_add_set(self%handle, c_text(name), length, indices), error)
  end subroutine add_set

  module procedure points_add_set_box
    character(*), parameter :: call = 'perion_points_add_set_box'
    integer(c_int32_t) :: dimension

    if (.not. is_live(self%handle, call, error)) return
    if (.not. ok(perion_points_dimension(self%handle, dimension), error)) return
    if (size(lower) /= dimension .or. size(upper) /= dimension) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''lower'' and ''upper'' have ' // &
          number(size(lower, kind=c_int64_t)) // ' and ' // number(size(upper, kind=c_int64_t)) // &
          ' numbers; the points have ' // number(int(dimension, c_int64_t)) // ' axes', error)
      return
    end if
    call check(perion_points_add_set_box(self%handle, c_text(name), lower, upper), error)
  end procedure points_add_set_box

  module procedure points_count_int64
    call check(perion_points_count(self%handle, count), error)
  end procedure points_count_int64

  module procedure points_count_int32
    integer(c_int64_t) :: wide

    if (ok(perion_points_count(self%handle, wide), error)) then
      call narrow('perion_points_count', wide, count, error)
    end if
  end procedure points_count_int32

  module procedure points_dimension_int64
    integer(c_int32_t) :: few

    if (ok(perion_points_dimension(self%handle, few), error)) dimension = few
  end procedure points_dimension_int64

  module procedure points_dimension_int32
    call check(perion_points_dimension(self%handle, dimension), error)
  end procedure points_dimension_int32

  module procedure points_set_count_int64
    call check(perion_points_set_count(self%handle, count), error)
  end procedure points_set_count_int64

  module procedure points_set_count_int32
    integer(c_int64_t) :: wide

    if (ok(perion_points_set_count(self%handle, wide), error)) then
      call narrow('perion_points_set_count', wide, count, error)
    end if
  end procedure points_set_count_int32

  module procedure points_get_set_name_int64
    character(*), parameter :: call = 'perion_points_get_set_name'
    character(kind=c_char), target :: letters(PERION_NAME_CAPACITY)
    integer(c_int64_t) :: count

    if (.not. is_live(self%handle, call, error)) return
    if (.not. ok(perion_points_set_count(self%handle, count), error)) return
    if (index < 1 .or. index > count) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''index'' is ' // number(index) // &
          '; sets are 1 to ' // number(count), error)
      return
    end if
    if (ok(perion_points_get_set_name(self%handle, index - 1, letters, &
        size(letters, kind=c_int64_t)), error)) name = f_text(c_loc(letters))
  end procedure points_get_set_name_int64

  module procedure points_get_set_name_int32
    call points_get_set_name_int64(self, int(index, c_int64_t), name, error)
  end procedure points_get_set_name_int32

  module procedure points_set_size_int64
    call check(perion_points_set_size(self%handle, c_text(name), count), error)
  end procedure points_set_size_int64

  module procedure points_set_size_int32
    integer(c_int64_t) :: wide

    if (ok(perion_points_set_size(self%handle, c_text(name), wide), error)) then
      call narrow('perion_points_set_size', wide, count, error)
    end if
  end procedure points_set_size_int32

  module procedure points_get_set_int64
    character(*), parameter :: call = 'perion_points_get_set'
    integer(c_int64_t), allocatable :: places(:)
    integer :: flaw

    allocate (places(size(indices, kind=c_int64_t)), stat=flaw)
    if (.not. room(flaw, call, error)) return
    if (ok(perion_points_get_set(self%handle, c_text(name), size(places, kind=c_int64_t), places), &
        error)) indices = places + 1
  end procedure points_get_set_int64

  module procedure points_get_set_int32
    character(*), parameter :: call = 'perion_points_get_set'
    integer(c_int64_t), allocatable :: places(:)
    integer :: flaw

    allocate (places(size(indices, kind=c_int64_t)), stat=flaw)
    if (.not. room(flaw, call, error)) return
    if (ok(perion_points_get_set(self%handle, c_text(name), size(places, kind=c_int64_t), places), &
        error)) indices = int(places + 1, c_int32_t)
  end procedure points_get_set_int32

  module procedure points_get_coordinates
    character(*), parameter :: call = 'perion_points_get_coordinates'
    real(c_double), pointer, contiguous :: start(:)
    real(c_double), allocatable :: packed(:, :)
    integer(c_int64_t) :: count, stride
    integer(c_int32_t) :: dimension
    integer :: flaw

    if (.not. is_live(self%handle, call, error)) return
    if (.not. ok(perion_points_count(self%handle, count), error)) return
    if (.not. ok(perion_points_dimension(self%handle, dimension), error)) return
    if (size(coordinates, 1) /= dimension .or. size(coordinates, 2, c_int64_t) /= count) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''coordinates'' has the shape ' // &
          shape_text(shape(coordinates, c_int64_t)) // ', not ' // &
          shape_text([int(dimension, c_int64_t), count]), error)
      return
    end if
    call in_place(coordinates, start, stride)
    if (associated(start) .and. stride == dimension) then
      call check(perion_points_get_coordinates(self%handle, start, dimension * count), error)
    else
      allocate (packed(dimension, count), stat=flaw)
      if (.not. room(flaw, call, error)) return
      if (ok(perion_points_get_coordinates(self%handle, packed, dimension * count), error)) &
          coordinates = packed
    end if
  end procedure points_get_coordinates

  module procedure points_get_volumes
    character(*), parameter :: call = 'perion_points_get_volumes'
    real(c_double), allocatable :: packed(:)
    integer :: flaw

    allocate (packed(size(volumes, kind=c_int64_t)), stat=flaw)
    if (.not. room(flaw, call, error)) return
    if (ok(perion_points_get_volumes(self%handle, packed, size(packed, kind=c_int64_t)), error)) &
        volumes = packed
  end procedure points_get_volumes

  module procedure points_destroy
    call check(perion_points_destroy(self%handle), error)
  end procedure points_destroy

  module procedure points_assign
    call refuse_assignment('perion_points', c_associated(left%handle), c_associated(right%handle))
  end procedure points_assign

  module procedure points_free
    integer(c_int32_t) :: status

    ! A call that still uses them keeps them.
    status = perion_points_destroy(self%handle)
  end procedure points_free

end submodule points_procedures
