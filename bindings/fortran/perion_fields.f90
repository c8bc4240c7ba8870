!> Simulations: fields copied, set, summed and lent.
submodule (perion) fields_procedures
  use, intrinsic :: iso_c_binding, only: c_associated, c_f_pointer, c_sizeof
  use perion_c, only: perion_simulation_borrow, perion_simulation_borrow_const, &
      perion_simulation_divergence, perion_simulation_get, perion_simulation_get_strided, &
      perion_simulation_gradient, perion_simulation_return, &
      perion_simulation_set, perion_simulation_set_strided, perion_simulation_sum, perion_view_init
  use perion_support
  implicit none

  !> The fields with one number an axis, a pair of axes, and those with one number. A field of a later
  !> library is in none: then the library is the one to refuse a shape.
  integer(c_int32_t), parameter :: vectors(*) = [PERION_FIELD_REFERENCE_POSITION, &
      PERION_FIELD_POSITION, PERION_FIELD_DISPLACEMENT, PERION_FIELD_VELOCITY, &
      PERION_FIELD_ACCELERATION, PERION_FIELD_INTERNAL_FORCE, PERION_FIELD_BODY_FORCE, &
      PERION_FIELD_REACTION]
  integer(c_int32_t), parameter :: tensors(*) = [PERION_FIELD_DEFORMATION_GRADIENT, &
      PERION_FIELD_STRAIN, PERION_FIELD_PLASTIC_STRAIN, PERION_FIELD_FIRST_PIOLA_STRESS, &
      PERION_FIELD_CAUCHY_STRESS, &
      PERION_FIELD_SHAPE_TENSOR, PERION_FIELD_MIXED_SHAPE_TENSOR, &
      PERION_FIELD_DEFORMED_SHAPE_TENSOR]
  integer(c_int32_t), parameter :: scalars(*) = [PERION_FIELD_VOLUME, PERION_FIELD_DENSITY, &
      PERION_FIELD_DAMAGE, PERION_FIELD_STRAIN_ENERGY_DENSITY, &
      PERION_FIELD_STABILIZATION_ENERGY_DENSITY, &
      PERION_FIELD_DISSIPATED_ENERGY_DENSITY, PERION_FIELD_STRESS_33, &
      PERION_FIELD_VON_MISES_STRESS, PERION_FIELD_DILATATION, PERION_FIELD_NEIGHBOR_COUNT, &
      PERION_FIELD_TIME_STEP_ESTIMATE, PERION_FIELD_EQUIVALENT_PLASTIC_STRAIN]

contains

  module procedure get_vectors
    character(*), parameter :: call = 'perion_simulation_get'
    real(c_double), pointer, contiguous :: start(:)
    real(c_double), allocatable :: packed(:, :)
    integer(c_int64_t) :: components, count, stride
    integer :: flaw

    if (.not. fits(self, call, field, shape(values, c_int64_t), set, error)) return
    components = size(values, 1, c_int64_t)
    count = size(values, 2, c_int64_t)
    call in_place(values, start, stride)
    if (associated(start)) then
      call check(fetched(self, field, start, components, count, stride, set), error)
    else
      allocate (packed(components, count), stat=flaw)
      if (.not. room(flaw, call, error)) return
      if (ok(fetched(self, field, packed, components, count, components, set), error)) values = packed
    end if
  end procedure get_vectors

  module procedure get_scalars
    character(*), parameter :: call = 'perion_simulation_get'
    real(c_double), pointer, contiguous :: start(:)
    real(c_double), allocatable :: packed(:)
    integer(c_int64_t) :: count, stride
    integer :: flaw

    if (.not. fits(self, call, field, shape(values, c_int64_t), set, error)) return
    count = size(values, kind=c_int64_t)
    call in_place(values, start, stride)
    if (associated(start)) then
      call check(fetched(self, field, start, 1_c_int64_t, count, stride, set), error)
    else
      allocate (packed(count), stat=flaw)
      if (.not. room(flaw, call, error)) return
      if (ok(fetched(self, field, packed, 1_c_int64_t, count, 1_c_int64_t, set), error)) values = packed
    end if
  end procedure get_scalars

  module procedure get_tensors
    character(*), parameter :: call = 'perion_simulation_get'
    real(c_double), allocatable :: packed(:, :)
    integer(c_int64_t) :: count, k
    integer :: axes, flaw

    if (.not. fits(self, call, field, shape(values, c_int64_t), set, error)) return
    axes = size(values, 1)
    count = size(values, 3, c_int64_t)
    allocate (packed(axes * axes, count), stat=flaw)
    if (.not. room(flaw, call, error)) return
    if (.not. ok(fetched(self, field, packed, size(packed, 1, c_int64_t), count, &
        size(packed, 1, c_int64_t), set), error)) return
    do k = 1, count
      values(:, :, k) = from_rows(packed(:, k), axes)
    end do
  end procedure get_tensors

  !> A tensor that C has row after row.
  pure function from_rows(rows, axes) result(tensor)
    real(c_double), intent(in) :: rows(:)
    integer, intent(in) :: axes
    real(c_double) :: tensor(axes, axes)

    tensor = transpose(reshape(rows, [axes, axes]))
  end function from_rows

  !> Copies a field into numbers of the host that are `stride` apart from point to point.
  recursive function fetched(self, field, values, components, count, stride, set) result(status)
    class(perion_simulation), intent(in) :: self
    integer(c_int32_t), intent(in) :: field
    real(c_double), intent(inout) :: values(*)
    integer(c_int64_t), intent(in) :: components, count, stride
    character(*), optional, intent(in) :: set
    integer(c_int32_t) :: status

    if (present(set)) then
      status = perion_simulation_get_strided(self%handle, c_text(set), field, values, count, stride)
    else if (stride == components) then
      status = perion_simulation_get(self%handle, field, values, components * count)
    else
      status = perion_simulation_get_strided(self%handle, field=field, values=values, count=count, &
          stride=stride)
    end if
  end function fetched

  module procedure set_vectors
    character(*), parameter :: call = 'perion_simulation_set'
    real(c_double), pointer, contiguous :: start(:)
    real(c_double), allocatable :: packed(:, :)
    integer(c_int64_t) :: components, count, stride
    integer :: flaw

    if (.not. fits(self, call, field, shape(values, c_int64_t), set, error)) return
    components = size(values, 1, c_int64_t)
    count = size(values, 2, c_int64_t)
    call in_place(values, start, stride)
    if (associated(start)) then
      call check(stored(self, field, start, components, count, stride, set), error)
    else
      allocate (packed(components, count), stat=flaw)
      if (.not. room(flaw, call, error)) return
      packed(:, :) = values
      call check(stored(self, field, packed, components, count, components, set), error)
    end if
  end procedure set_vectors

  module procedure set_scalars
    character(*), parameter :: call = 'perion_simulation_set'
    real(c_double), pointer, contiguous :: start(:)
    real(c_double), allocatable :: packed(:)
    integer(c_int64_t) :: count, stride
    integer :: flaw

    if (.not. fits(self, call, field, shape(values, c_int64_t), set, error)) return
    count = size(values, kind=c_int64_t)
    call in_place(values, start, stride)
    if (associated(start)) then
      call check(stored(self, field, start, 1_c_int64_t, count, stride, set), error)
    else
      allocate (packed(count), stat=flaw)
      if (.not. room(flaw, call, error)) return
      packed(:) = values
      call check(stored(self, field, packed, 1_c_int64_t, count, 1_c_int64_t, set), error)
    end if
  end procedure set_scalars

  !> Sets a field from numbers of the host that are `stride` apart from point to point.
  recursive function stored(self, field, values, components, count, stride, set) result(status)
    class(perion_simulation), intent(in) :: self
    integer(c_int32_t), intent(in) :: field
    real(c_double), intent(in) :: values(*)
    integer(c_int64_t), intent(in) :: components, count, stride
    character(*), optional, intent(in) :: set
    integer(c_int32_t) :: status

    if (present(set)) then
      status = perion_simulation_set_strided(self%handle, c_text(set), field, values, count, stride)
    else if (stride == components) then
      status = perion_simulation_set(self%handle, field, values, components * count)
    else
      status = perion_simulation_set_strided(self%handle, field=field, values=values, count=count, &
          stride=stride)
    end if
  end function stored

  module procedure sum_components
    if (.not. adds_up(self, field, shape(components, c_int64_t), error)) return
    call check(summed(self, field, components, set), error)
  end procedure sum_components

  module procedure sum_scalar
    real(c_double) :: numbers(9)

    if (.not. adds_up(self, field, shape(components, c_int64_t), error)) return
    if (ok(summed(self, field, numbers, set), error)) components = numbers(1)
  end procedure sum_scalar

  module procedure sum_tensor
    real(c_double) :: numbers(9)
    integer :: axes

    if (.not. adds_up(self, field, shape(components, c_int64_t), error)) return
    axes = size(components, 1)
    if (ok(summed(self, field, numbers, set), error)) components = from_rows(numbers(:axes * axes), axes)
  end procedure sum_tensor

  recursive function summed(self, field, components, set) result(status)
    class(perion_simulation), intent(in) :: self
    integer(c_int32_t), intent(in) :: field
    real(c_double), intent(inout) :: components(*)
    character(*), optional, intent(in) :: set
    integer(c_int32_t) :: status

    if (present(set)) then
      status = perion_simulation_sum(self%handle, field, c_text(set), components)
    else
      status = perion_simulation_sum(self%handle, field, components=components)
    end if
  end function summed

  !> Whether there is a simulation, and an array has the shape of one of its fields.
  recursive function fits(self, call, field, extents, set, error)
    class(perion_simulation), intent(in) :: self
    character(*), intent(in) :: call
    integer(c_int32_t), intent(in) :: field
    integer(c_int64_t), intent(in) :: extents(:)
    character(*), optional, intent(in) :: set
    type(perion_error), allocatable, optional, intent(inout) :: error
    character(:), allocatable :: expected
    logical :: fits
    integer :: rank

    fits = is_live(self%handle, call, error)
    if (.not. fits) return
    rank = rank_of(field)
    if (rank < 0) return
    fits = size(extents) == rank + 1
    if (fits) fits = all(extents(:rank) == self%axes)
    if (.not. present(set)) fits = fits .and. extents(size(extents)) == self%points
    if (fits) return
    expected = 'count'
    if (.not. present(set)) expected = number(self%points)
    expected = repeat(number(self%axes) // ',', rank) // expected
    call refuse(PERION_ERROR_ARGUMENT, call // ': ''values'' has the shape ' // &
        shape_text(extents) // '; field ' // number(int(field, c_int64_t)) // ' needs (' // &
        expected // ')', error)
  end function fits

  !> Number of axes that a number of a field is for; -1 of a number that is no field, which is the library's to
  !> refuse.
  pure function rank_of(field) result(rank)
    integer(c_int32_t), intent(in) :: field
    integer :: rank

    rank = -1
    if (any(field == scalars)) rank = 0
    if (any(field == vectors)) rank = 1
    if (any(field == tensors)) rank = 2
  end function rank_of

  !> Whether there is a simulation, and numbers of this shape are what a field adds up to. A vector of one
  !> takes one number too.
  recursive function adds_up(self, field, extents, error)
    class(perion_simulation), intent(in) :: self
    integer(c_int32_t), intent(in) :: field
    integer(c_int64_t), intent(in) :: extents(:)
    type(perion_error), allocatable, optional, intent(inout) :: error
    character(*), parameter :: call = 'perion_simulation_sum'
    integer(c_int64_t) :: length
    logical :: adds_up
    integer :: rank

    adds_up = is_live(self%handle, call, error)
    if (.not. adds_up) return
    rank = rank_of(field)
    length = product(extents)
    if (rank < 0) then
      ! Room for what the library might write.
      adds_up = size(extents) == 0 .or. all(extents == self%axes)
      rank = size(extents)
    else if (rank == 2 .or. size(extents) == 2) then
      adds_up = size(extents) == rank
      if (adds_up) adds_up = all(extents == self%axes)
    else
      adds_up = length == self%axes**rank
    end if
    if (.not. adds_up) call refuse(PERION_ERROR_ARGUMENT, call // ': ''components'' has ' // &
        number(length) // ' numbers; field ' // number(int(field, c_int64_t)) // ' adds up to ' // &
        number(self%axes**rank), error)
  end function adds_up

  module procedure gradient_vectors
    character(*), parameter :: call = 'perion_simulation_gradient'
    real(c_double), allocatable :: from(:, :), to(:, :)
    integer(c_int64_t) :: k, rows
    integer :: flaw

    if (.not. is_live(self%handle, call, error)) return
    rows = size(result, 1, c_int64_t)
    if (.not. agree(self, call, shape(field, c_int64_t), [rows, self%points], shape(result, c_int64_t), &
        [rows, self%axes, self%points], error)) return
    allocate (from(rows, self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    allocate (to(rows * self%axes, self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    from = field
    if (.not. ok(perion_simulation_gradient(self%handle, operator, int(rows, c_int32_t), from, to), &
        error)) return
    do k = 1, self%points
      result(:, :, k) = transpose(reshape(to(:, k), [self%axes, rows]))
    end do
  end procedure gradient_vectors

  module procedure gradient_scalars
    character(*), parameter :: call = 'perion_simulation_gradient'
    real(c_double), allocatable :: from(:), to(:, :)
    integer :: flaw

    if (.not. is_live(self%handle, call, error)) return
    if (.not. agree(self, call, shape(field, c_int64_t), [self%points], shape(result, c_int64_t), &
        [self%axes, self%points], error)) return
    allocate (from(self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    allocate (to(self%axes, self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    from = field
    if (ok(perion_simulation_gradient(self%handle, operator, 1_c_int32_t, from, to), error)) result = to
  end procedure gradient_scalars

  module procedure divergence_tensors
    character(*), parameter :: call = 'perion_simulation_divergence'
    real(c_double), allocatable :: from(:, :), to(:, :)
    integer(c_int64_t) :: k, rows, components
    integer :: flaw

    if (.not. is_live(self%handle, call, error)) return
    rows = size(result, 1, c_int64_t)
    if (.not. agree(self, call, shape(field, c_int64_t), [rows, self%axes, self%points], &
        shape(result, c_int64_t), [rows, self%points], error)) return
    components = rows * self%axes
    allocate (from(components, self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    allocate (to(rows, self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    do k = 1, self%points
      from(:, k) = reshape(transpose(field(:, :, k)), [components])
    end do
    if (ok(perion_simulation_divergence(self%handle, operator, int(components, c_int32_t), from, to), &
        error)) result = to
  end procedure divergence_tensors

  module procedure divergence_vectors
    character(*), parameter :: call = 'perion_simulation_divergence'
    real(c_double), allocatable :: from(:, :), to(:)
    integer :: flaw

    if (.not. is_live(self%handle, call, error)) return
    if (.not. agree(self, call, shape(field, c_int64_t), [self%axes, self%points], &
        shape(result, c_int64_t), [self%points], error)) return
    allocate (from(self%axes, self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    allocate (to(self%points), stat=flaw)
    if (.not. room(flaw, call, error)) return
    from = field
    if (ok(perion_simulation_divergence(self%handle, operator, int(self%axes, c_int32_t), from, to), &
        error)) result = to
  end procedure divergence_vectors

  !> Whether a field and its derivative have the shapes they need.
  recursive function agree(self, call, field, needed, result, made, error)
    class(perion_simulation), intent(in) :: self
    character(*), intent(in) :: call
    integer(c_int64_t), intent(in) :: field(:), needed(:), result(:), made(:)
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: agree

    agree = all(field == needed) .and. all(result == made)
    if (.not. agree) call refuse(PERION_ERROR_ARGUMENT, call // ': ''field'' has the shape ' // &
        shape_text(field) // ' and ''result'' ' // shape_text(result) // '; of ' // &
        number(self%points) // ' points in ' // number(self%axes) // &
        ' dimensions they need ' // shape_text(needed) // ' and ' // shape_text(made), error)
  end function agree

  module procedure simulation_borrow
    character(*), parameter :: call = 'perion_simulation_borrow'
    type(raw_view) :: lent

    if (.not. is_free(view, call, error)) return
    call perion_view_init(lent, c_sizeof(lent))
    if (ok(perion_simulation_borrow(self%handle, field, lent), error)) then
      call open_view(self, call, lent, view, error)
    end if
  end procedure simulation_borrow

  module procedure simulation_borrow_const
    character(*), parameter :: call = 'perion_simulation_borrow_const'
    type(raw_view) :: lent

    if (.not. is_free(view, call, error)) return
    call perion_view_init(lent, c_sizeof(lent))
    if (ok(perion_simulation_borrow_const(self%handle, field, lent), error)) then
      call open_view(self, call, lent, view, error)
    end if
  end procedure simulation_borrow_const

  !> Whether a view holds no loan, which another one would put out of reach.
  recursive function is_free(view, call, error)
    type(perion_view), intent(in) :: view
    character(*), intent(in) :: call
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: is_free

    is_free = view%lent%struct_size == 0
    if (.not. is_free) call refuse(PERION_ERROR_STATE, call // ': ''view'' holds a field on loan; ' // &
        'return it first, or say view = perion_view() where its simulation is gone', error)
  end function is_free

  !> Fills a view, whose components of a point must be neighbours.
  recursive subroutine open_view(self, call, lent, view, error)
    class(perion_simulation), intent(in) :: self
    character(*), intent(in) :: call
    type(raw_view), intent(inout) :: lent
    type(perion_view), intent(inout) :: view
    type(perion_error), allocatable, optional, intent(inout) :: error
    real(c_double), pointer :: all(:, :)
    integer(c_int32_t) :: status

    if (lent%component_stride /= 1) then
      status = perion_simulation_return(self%handle, lent)
      call refuse(PERION_ERROR_UNSUPPORTED, call // ': the library keeps the components of a ' // &
          'point apart, which a view cannot show; get the field', error)
      return
    end if
    view%lent = lent
    call c_f_pointer(lent%data, all, [lent%point_stride, lent%count])
    view%data => all(:lent%components, :)
    view%slot => null()
    if (c_associated(lent%slot)) call c_f_pointer(lent%slot, view%slot, [lent%count])
  end subroutine open_view

  module procedure simulation_return
    if (view%lent%struct_size == 0) then
      call refuse(PERION_ERROR_ARGUMENT, 'perion_simulation_return: nothing is borrowed in ''view''', &
          error)
      return
    end if
    if (.not. ok(perion_simulation_return(self%handle, view%lent), error)) return
    view%lent%struct_size = 0
    view%data => null()
    view%slot => null()
  end procedure simulation_return

  module procedure view_place_int64
    place = point
    if (associated(self%slot)) place = self%slot(point) + 1
  end procedure view_place_int64

  module procedure view_place_int32
    place = point
    if (associated(self%slot)) place = self%slot(point) + 1
  end procedure view_place_int32

end submodule fields_procedures
