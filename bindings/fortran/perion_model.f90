!> Models: made, told numbers, choices and laws, destroyed.
submodule (perion) model_procedures
  use, intrinsic :: iso_c_binding
  use perion_c, only: perion_model_choose, perion_model_create, perion_model_destroy, &
      perion_model_get, perion_model_set, perion_model_set_material_function
  use perion_support, only: c_text, check, number, ok, refuse, refuse_assignment, room
  implicit none

contains

  module procedure model_create
    type(c_ptr) :: fresh
    integer(c_int32_t) :: status

    fresh = c_null_ptr
    if (.not. ok(perion_model_create(c_text(formulation), fresh), error)) return
    status = perion_model_destroy(self%handle)
    if (status == PERION_OK) then
      call leave_material(self%material, is_model=.true.)
      self%handle = fresh
    else
      call check(status, error)
      status = perion_model_destroy(fresh)
    end if
  end procedure model_create

  module procedure model_set
    call check(perion_model_set(self%handle, c_text(key), value), error)
  end procedure model_set

  module procedure model_get
    call check(perion_model_get(self%handle, c_text(key), value), error)
  end procedure model_get

  module procedure model_choose
    call check(perion_model_choose(self%handle, c_text(key), c_text(choice)), error)
  end procedure model_choose

  module procedure model_destroy
    if (ok(perion_model_destroy(self%handle), error)) &
        call leave_material(self%material, is_model=.true.)
  end procedure model_destroy

  module procedure model_assign
    call refuse_assignment('perion_model', c_associated(left%handle), c_associated(right%handle))
  end procedure model_assign

  module procedure model_free
    ! A call that still uses it keeps it, and its law.
    if (perion_model_destroy(self%handle) == PERION_OK) &
        call leave_material(self%material, is_model=.true.)
  end procedure model_free

  module procedure set_material_function_int64
    type(material_holder), pointer :: holder
    integer :: flaw

    allocate (holder, stat=flaw)
    if (.not. room(flaw, 'perion_model_set_material_function', error)) return
    holder%host => material
    holder%state_size = state_size
    if (ok(perion_model_set_material_function(self%handle, state_size, c_funloc(ask_material), &
        c_loc(holder)), error)) then
      call leave_material(self%material, is_model=.true.)
      self%material => holder
    else
      deallocate (holder)
    end if
  end procedure set_material_function_int64

  module procedure set_material_function_int32
    call set_material_function_int64(self, int(state_size, c_int64_t), material, error)
  end procedure set_material_function_int32

  ! Simulations of one model may be made and end on several threads of the host.
  module procedure material_taken
    integer(c_int64_t) :: other

    other = dimension
    !$omp critical (perion_materials)
    if (holder%simulations > 0) other = holder%dimension
    if (other == dimension) then
      holder%dimension = dimension
      holder%simulations = holder%simulations + 1
    end if
    !$omp end critical (perion_materials)
    taken = other == dimension
    if (.not. taken) call refuse(PERION_ERROR_ARGUMENT, call // ': the law of ''model'' is in use for ' // &
        'points of dimension ' // number(other) // ', and here they have ' // number(dimension) // &
        '; give a model of its own the law', error)
  end procedure material_taken

  module procedure leave_material
    logical :: is_last

    if (.not. associated(holder)) return
    !$omp critical (perion_materials)
    if (is_model) then
      holder%has_model = .false.
    else
      holder%simulations = holder%simulations - 1
    end if
    is_last = holder%simulations == 0 .and. .not. holder%has_model
    !$omp end critical (perion_materials)
    if (is_last) deallocate (holder)
    holder => null()
  end procedure leave_material

  recursive function ask_material(user, count, F0, F1, state0, state1, P, W) bind(c, name='') &
      result(stop_now)
    type(c_ptr), value :: user
    integer(c_int64_t), value :: count
    real(c_double), target, intent(in) :: F0(*), F1(*), state0(*)
    real(c_double), target, intent(inout) :: state1(*), P(*), W(*)
    integer(c_int) :: stop_now
    type(material_holder), pointer :: holder
    real(c_double), pointer, contiguous :: rows(:, :, :), old(:, :), new(:, :)
    real(c_double), allocatable :: before(:, :, :), now(:, :, :), stress(:, :, :)
    integer(c_int64_t) :: n
    integer :: flaw
    logical :: stop

    call c_f_pointer(user, holder)
    n = holder%dimension
    ! Without memory there is no answer.
    stop_now = 1
    allocate (before(n, n, count), stat=flaw)
    if (flaw /= 0) return
    allocate (now(n, n, count), stat=flaw)
    if (flaw /= 0) return
    allocate (stress(n, n, count), stat=flaw)
    if (flaw /= 0) return
    call c_f_pointer(c_loc(F0), rows, [n, n, count])
    call turn_over(rows, before)
    call c_f_pointer(c_loc(F1), rows, [n, n, count])
    call turn_over(rows, now)
    call c_f_pointer(c_loc(P), rows, [n, n, count])
    call turn_over(rows, stress)
    call c_f_pointer(c_loc(state0), old, [holder%state_size, count])
    call c_f_pointer(c_loc(state1), new, [holder%state_size, count])
    stop = .false.
    call holder%host%answer(before, now, old, new, stress, W(:count), stop)
    call turn_over(stress, rows)
    stop_now = merge(1_c_int, 0_c_int, stop)
  end function ask_material

  !> C has tensors row after row, Fortran column after column.
  pure recursive subroutine turn_over(from, to)
    real(c_double), contiguous, intent(in) :: from(:, :, :)
    real(c_double), contiguous, intent(inout) :: to(:, :, :)
    integer(c_int64_t) :: row, column, place

    do place = 1, size(from, 3, c_int64_t)
      do column = 1, size(from, 2, c_int64_t)
        do row = 1, size(from, 1, c_int64_t)
          to(row, column, place) = from(column, row, place)
        end do
      end do
    end do
  end subroutine turn_over

end submodule model_procedures
