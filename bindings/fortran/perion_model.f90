!> Models: made, told numbers and choices, destroyed.
submodule (perion) model_procedures
  use, intrinsic :: iso_c_binding, only: c_associated
  use perion_c, only: perion_model_choose, perion_model_create, perion_model_destroy, &
      perion_model_get, perion_model_set
  use perion_support, only: c_text, check, ok, refuse_assignment
  implicit none

contains

  module procedure model_create
    type(c_ptr) :: fresh
    integer(c_int32_t) :: status

    fresh = c_null_ptr
    if (.not. ok(perion_model_create(c_text(formulation), fresh), error)) return
    status = perion_model_destroy(self%handle)
    if (status == PERION_OK) then
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
    call check(perion_model_destroy(self%handle), error)
  end procedure model_destroy

  module procedure model_assign
    call refuse_assignment('perion_model', c_associated(left%handle), c_associated(right%handle))
  end procedure model_assign

  module procedure model_free
    integer(c_int32_t) :: status

    ! A call that still uses it keeps it.
    status = perion_model_destroy(self%handle)
  end procedure model_free

end submodule model_procedures
