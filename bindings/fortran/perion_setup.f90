!> Simulations: made, set up, their bonds, destroyed.
submodule (perion) setup_procedures
  use, intrinsic :: iso_c_binding, only: c_associated
  use perion_c, only: perion_simulation_assign_model, perion_simulation_bond_count, &
      perion_simulation_break_bonds, perion_simulation_break_crossing, perion_simulation_create, &
      perion_simulation_destroy, perion_simulation_dimension, perion_simulation_forbid_failure, &
      perion_simulation_get_bonds, perion_simulation_point_count, &
      perion_simulation_set_bond_integrity, perion_simulation_set_interface, &
      perion_simulation_set_threads
  use perion_support
  implicit none

contains

  module procedure simulation_create
    integer(c_int64_t) :: count
    integer(c_int32_t) :: dimension, status
    type(c_ptr) :: fresh
    type(material_use), pointer :: use

    fresh = c_null_ptr
    use => null()
    if (.not. ok(perion_simulation_create(points%handle, model%handle, fresh), error)) return
    status = perion_simulation_point_count(fresh, count)
    if (status == PERION_OK) status = perion_simulation_dimension(fresh, dimension)
    if (status == PERION_OK) then
      if (.not. law_used(model, int(dimension, c_int64_t), 'perion_simulation_create', use, error)) then
        status = perion_simulation_destroy(fresh)
        return
      end if
      status = perion_simulation_destroy(self%handle)
    end if
    if (status == PERION_OK) then
      call free_callbacks(self)
      self%materials => use
      self%handle = fresh
      self%axes = dimension
      self%points = count
    else
      call check(status, error)
      status = perion_simulation_destroy(fresh)
      call leave_materials(use)
    end if
  end procedure simulation_create

  module procedure simulation_assign_model
    character(*), parameter :: call = 'perion_simulation_assign_model'
    type(material_use), pointer :: use

    if (.not. is_live(self%handle, call, error)) return
    if (.not. law_used(model, self%axes, call, use, error)) return
    if (.not. ok(perion_simulation_assign_model(self%handle, c_text(set), model%handle), error)) then
      call leave_materials(use)
    else if (associated(use)) then
      use%next => self%materials
      self%materials => use
    end if
  end procedure simulation_assign_model

  !> Whether the law of a model, if it has one of the host's, can be used for points of a dimension;
  !> `use` is null where it has none.
  recursive function law_used(model, dimension, call, use, error)
    class(perion_model), intent(in) :: model
    integer(c_int64_t), intent(in) :: dimension
    character(*), intent(in) :: call
    type(material_use), pointer, intent(out) :: use
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: law_used
    integer :: flaw

    use => null()
    law_used = .true.
    if (.not. associated(model%material)) return
    allocate (use, stat=flaw)
    law_used = room(flaw, call, error)
    if (.not. law_used) return
    law_used = material_taken(model%material, dimension, call, error)
    if (law_used) then
      use%holder => model%material
    else
      deallocate (use)
    end if
  end function law_used

  !> Leaves all material functions of a list, and frees it.
  recursive subroutine leave_materials(uses)
    type(material_use), pointer, intent(inout) :: uses
    type(material_use), pointer :: use

    do while (associated(uses))
      use => uses
      uses => use%next
      call leave_material(use%holder, is_model=.false.)
      deallocate (use)
    end do
  end subroutine leave_materials

  module procedure simulation_set_interface
    call check(perion_simulation_set_interface(self%handle, c_text(set_a), c_text(set_b), &
        critical_energy_release_rate), error)
  end procedure simulation_set_interface

  module procedure simulation_forbid_failure
    call check(perion_simulation_forbid_failure(self%handle, c_text(set)), error)
  end procedure simulation_forbid_failure

  module procedure set_threads_int64
    integer(c_int64_t), parameter :: largest = huge(1_c_int32_t)

    ! What does not fit into 32 bits is refused like any number beyond the limit.
    call set_threads_int32(self, int(max(-largest, min(threads, largest)), c_int32_t), error)
  end procedure set_threads_int64

  module procedure set_threads_int32
    call check(perion_simulation_set_threads(self%handle, threads), error)
  end procedure set_threads_int32

  module procedure point_count_int64
    call check(perion_simulation_point_count(self%handle, count), error)
  end procedure point_count_int64

  module procedure point_count_int32
    integer(c_int64_t) :: wide

    if (ok(perion_simulation_point_count(self%handle, wide), error)) then
      call narrow('perion_simulation_point_count', wide, count, error)
    end if
  end procedure point_count_int32

  module procedure dimension_int64
    integer(c_int32_t) :: few

    if (ok(perion_simulation_dimension(self%handle, few), error)) dimension = few
  end procedure dimension_int64

  module procedure dimension_int32
    call check(perion_simulation_dimension(self%handle, dimension), error)
  end procedure dimension_int32

  module procedure simulation_destroy
    if (ok(perion_simulation_destroy(self%handle), error)) call free_callbacks(self)
  end procedure simulation_destroy

  module procedure simulation_assign
    call refuse_assignment('perion_simulation', c_associated(left%handle), &
        c_associated(right%handle))
  end procedure simulation_assign

  module procedure simulation_free
    ! A call that still uses it keeps it, and its callbacks.
    if (perion_simulation_destroy(self%handle) == PERION_OK) call free_callbacks(self)
  end procedure simulation_free

  recursive subroutine free_callbacks(self)
    class(perion_simulation), intent(inout) :: self
    type(function_holder), pointer :: holder

    do while (associated(self%functions))
      holder => self%functions
      self%functions => holder%next
      deallocate (holder)
    end do
    call leave_materials(self%materials)
    if (associated(self%progress)) deallocate (self%progress)
    if (associated(self%log)) deallocate (self%log)
  end subroutine free_callbacks

  module procedure break_bonds_int64
    character(*), parameter :: call = 'perion_simulation_break_bonds'
    integer(c_int64_t), allocatable :: places(:, :)

    if (.not. hold_pairs(self, call, shape(pairs, c_int64_t), places, error)) return
    places(:, :) = pairs
    call break_places(self, places, error)
  end procedure break_bonds_int64

  module procedure break_bonds_int32
    character(*), parameter :: call = 'perion_simulation_break_bonds'
    integer(c_int64_t), allocatable :: places(:, :)

    if (.not. hold_pairs(self, call, shape(pairs, c_int64_t), places, error)) return
    places(:, :) = pairs
    call break_places(self, places, error)
  end procedure break_bonds_int32

  !> Breaks bonds by pairs of indices, which become the library's.
  recursive subroutine break_places(self, pairs, error)
    class(perion_simulation), intent(in) :: self
    integer(c_int64_t), allocatable, intent(inout) :: pairs(:, :)
    type(perion_error), allocatable, optional, intent(inout) :: error
    character(*), parameter :: call = 'perion_simulation_break_bonds'

    if (from_one(call, 'pairs', size(pairs, kind=c_int64_t), pairs, self%points, error)) &
        call check(perion_simulation_break_bonds(self%handle, size(pairs, 2, c_int64_t), pairs), error)
  end subroutine break_places

  module procedure simulation_break_crossing
    character(*), parameter :: call = 'perion_simulation_break_crossing'

    if (.not. is_live(self%handle, call, error)) return
    if (size(vertices, 1, c_int64_t) /= self%axes) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': ''vertices'' has the shape ' // &
          shape_text(shape(vertices, c_int64_t)) // '; it must be (' // number(self%axes) // &
          ',vertex_count)', error)
      return
    end if
    call check(perion_simulation_break_crossing(self%handle, size(vertices, 2, c_int64_t), vertices), &
        error)
  end procedure simulation_break_crossing

  module procedure set_bond_integrity_int64
    character(*), parameter :: call = 'perion_simulation_set_bond_integrity'
    integer(c_int64_t), allocatable :: places(:, :)

    if (.not. hold_pairs(self, call, shape(pairs, c_int64_t), places, error)) return
    places(:, :) = pairs
    call set_integrity(self, places, values, error)
  end procedure set_bond_integrity_int64

  module procedure set_bond_integrity_int32
    character(*), parameter :: call = 'perion_simulation_set_bond_integrity'
    integer(c_int64_t), allocatable :: places(:, :)

    if (.not. hold_pairs(self, call, shape(pairs, c_int64_t), places, error)) return
    places(:, :) = pairs
    call set_integrity(self, places, values, error)
  end procedure set_bond_integrity_int32

  !> Sets the integrity of bonds by pairs of indices, which become the library's.
  recursive subroutine set_integrity(self, pairs, values, error)
    class(perion_simulation), intent(in) :: self
    integer(c_int64_t), allocatable, intent(inout) :: pairs(:, :)
    real(c_double), target, intent(in) :: values(:)
    type(perion_error), allocatable, optional, intent(inout) :: error
    character(*), parameter :: call = 'perion_simulation_set_bond_integrity'
    real(c_double), allocatable, target :: copy(:)
    real(c_double), pointer, contiguous :: each(:)
    integer(c_int64_t) :: count

    count = size(pairs, 2, c_int64_t)
    if (.not. have_length(call, 'pairs', size(values, kind=c_int64_t), count, error)) return
    if (.not. from_one(call, 'pairs', 2 * count, pairs, self%points, error)) return
    if (.not. lined_up(values, copy, each, call, error)) return
    call check(perion_simulation_set_bond_integrity(self%handle, count, pairs, each), error)
  end subroutine set_integrity

  module procedure get_bonds_int64
    character(*), parameter :: call = 'perion_simulation_get_bonds'
    integer(c_int64_t), allocatable :: places(:, :)
    integer(c_int64_t) :: capacity, count
    integer :: flaw

    capacity = size(pairs, 2, c_int64_t)
    if (.not. are_pairs(self, call, shape(pairs, c_int64_t), error)) return
    if (.not. hold_bonds(self, capacity, stretch, integrity, count, error)) return
    allocate (places(2, count), stat=flaw)
    if (.not. room(flaw, call, error)) return
    if (bonds_listed(self, count, places, stretch, integrity, error)) &
        pairs(:, :count) = places + 1
  end procedure get_bonds_int64

  module procedure get_bonds_int32
    character(*), parameter :: call = 'perion_simulation_get_bonds'
    integer(c_int64_t), allocatable :: places(:, :)
    integer(c_int64_t) :: capacity, count
    integer :: flaw

    capacity = size(pairs, 2, c_int64_t)
    if (.not. are_pairs(self, call, shape(pairs, c_int64_t), error)) return
    if (.not. hold_bonds(self, capacity, stretch, integrity, count, error)) return
    allocate (places(2, count), stat=flaw)
    if (.not. room(flaw, call, error)) return
    if (bonds_listed(self, count, places, stretch, integrity, error)) &
        pairs(:, :count) = int(places + 1, c_int32_t)
  end procedure get_bonds_int32

  module procedure get_bonds_without_pairs
    integer(c_int64_t) :: capacity, count
    logical :: are_listed

    if (.not. is_live(self%handle, 'perion_simulation_get_bonds', error)) return
    capacity = 0
    if (present(integrity)) capacity = size(integrity, kind=c_int64_t)
    if (present(stretch)) capacity = size(stretch, kind=c_int64_t)
    if (.not. hold_bonds(self, capacity, stretch, integrity, count, error)) return
    are_listed = bonds_listed(self, count, stretch=stretch, integrity=integrity, error=error)
  end procedure get_bonds_without_pairs

  !> Whether all bonds could be listed. What comes of them is put into the host's arrays, sections or
  !> not, from arrays of its own on the heap.
  recursive function bonds_listed(self, count, places, stretch, integrity, error)
    class(perion_simulation), intent(in) :: self
    integer(c_int64_t), intent(in) :: count
    integer(c_int64_t), optional, intent(inout) :: places(2, count)
    real(c_double), optional, intent(inout) :: stretch(:), integrity(:)
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: bonds_listed
    character(*), parameter :: call = 'perion_simulation_get_bonds'
    ! Not allocated they are absent from the call.
    real(c_double), allocatable :: stretches(:), integrities(:)
    integer(c_int64_t) :: written
    integer :: flaw

    flaw = 0
    if (present(stretch)) allocate (stretches(count), stat=flaw)
    if (present(integrity) .and. flaw == 0) allocate (integrities(count), stat=flaw)
    bonds_listed = room(flaw, call, error)
    if (.not. bonds_listed) return
    bonds_listed = ok(perion_simulation_get_bonds(self%handle, count, places, stretches, integrities, &
        written), error)
    if (.not. bonds_listed) return
    call hand_over(stretches, stretch)
    call hand_over(integrities, integrity)
  end function bonds_listed

  recursive subroutine hand_over(values, array)
    real(c_double), allocatable, intent(in) :: values(:)
    real(c_double), optional, intent(inout) :: array(:)

    if (present(array)) array(:size(values)) = values
  end subroutine hand_over

  module procedure bond_count_int64
    call check(perion_simulation_bond_count(self%handle, count), error)
  end procedure bond_count_int64

  module procedure bond_count_int32
    integer(c_int64_t) :: wide

    if (ok(perion_simulation_bond_count(self%handle, wide), error)) then
      call narrow('perion_simulation_bond_count', wide, count, error)
    end if
  end procedure bond_count_int32

  !> Whether there is a simulation, and an array has the shape of pairs.
  recursive function are_pairs(self, call, extents, error)
    class(perion_simulation), intent(in) :: self
    character(*), intent(in) :: call
    integer(c_int64_t), intent(in) :: extents(2)
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: are_pairs

    are_pairs = is_live(self%handle, call, error)
    if (.not. are_pairs) return
    are_pairs = extents(1) == 2
    if (.not. are_pairs) call refuse(PERION_ERROR_ARGUMENT, call // &
        ': ''pairs'' has the shape ' // shape_text(extents) // '; it must be (2,count)', error)
  end function are_pairs

  !> Whether there is a simulation, an array has the shape of pairs, and there is room for them.
  recursive function hold_pairs(self, call, extents, places, error)
    class(perion_simulation), intent(in) :: self
    character(*), intent(in) :: call
    integer(c_int64_t), intent(in) :: extents(2)
    integer(c_int64_t), allocatable, intent(out) :: places(:, :)
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: hold_pairs
    integer :: flaw

    hold_pairs = are_pairs(self, call, extents, error)
    if (.not. hold_pairs) return
    allocate (places(2, extents(2)), stat=flaw)
    hold_pairs = room(flaw, call, error)
  end function hold_pairs

  !> Whether an array of values is as long as another.
  recursive function have_length(call, other, length, expected, error)
    character(*), intent(in) :: call, other
    integer(c_int64_t), intent(in) :: length, expected
    type(perion_error), allocatable, optional, intent(inout) :: error
    logical :: have_length

    have_length = length == expected
    if (.not. have_length) call refuse(PERION_ERROR_ARGUMENT, call // ': there are ' // &
        number(length) // ' values for ' // number(expected) // ' of ''' // other // '''', error)
  end function have_length

  !> Whether the arrays of a list of bonds are of one length and hold all bonds.
  recursive function hold_bonds(self, capacity, stretch, integrity, count, error)
    class(perion_simulation), intent(in) :: self
    integer(c_int64_t), intent(in) :: capacity
    real(c_double), optional, intent(in) :: stretch(:), integrity(:)
    integer(c_int64_t), intent(out) :: count
    type(perion_error), allocatable, optional, intent(inout) :: error
    character(*), parameter :: call = 'perion_simulation_get_bonds'
    integer(c_int64_t) :: lengths(2)
    logical :: hold_bonds

    lengths = capacity
    if (present(stretch)) lengths(1) = size(stretch, kind=c_int64_t)
    if (present(integrity)) lengths(2) = size(integrity, kind=c_int64_t)
    count = 0
    hold_bonds = .false.
    if (any(lengths /= capacity)) then
      call refuse(PERION_ERROR_ARGUMENT, call // ': the arrays have different lengths', error)
      return
    end if
    if (.not. ok(perion_simulation_bond_count(self%handle, count), error)) return
    hold_bonds = capacity >= count
    if (.not. hold_bonds) call refuse(PERION_ERROR_ARGUMENT, call // ': the arrays have room for ' // &
        number(capacity) // ' bonds, but there are ' // number(count), error)
  end function hold_bonds

end submodule setup_procedures
