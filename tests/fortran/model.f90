!> Models: numbers, choices, and the lists of what there is.
module model_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes, only: make_material
  use testing
  implicit none
  private
  public :: test_model

  character(*), parameter :: file = 'model.f90'

contains

  subroutine test_model()
    call run(file, 'a number comes back with the same bits, or its default', numbers_come_back)
    call run(file, 'a misspelt name is put right', misspelt_names)
    call run(file, 'a value out of range changes nothing', values_out_of_range)
    call run(file, 'choices are made by their words', choices_by_words)
    call run(file, 'formulations and keys are listed', lists_are_complete)
  end subroutine test_model

  subroutine numbers_come_back()
    type(c_ptr) :: model
    real(c_double) :: value

    model = c_null_ptr
    call assert_ok(perion_model_create(c('bond_based'), model))
    call assert_refused(perion_model_get(model, c('density'), value), PERION_ERROR_STATE, &
        "'density' was not set")
    call assert_ok(perion_model_get(model, c('thickness'), value))
    call assert(same_bits(value, 1.0_c_double), 'the default thickness is not 1')
    call assert_ok(perion_model_set(model, c('density'), 0.1_c_double))
    call assert_ok(perion_model_get(model, c('density'), value))
    call assert(same_bits(value, 0.1_c_double), 'the density has come back another')
    call assert_ok(perion_model_destroy(model))
    call assert(.not. c_associated(model), 'the handle is not null')
  end subroutine numbers_come_back

  subroutine misspelt_names()
    type(c_ptr) :: model

    model = c_null_ptr
    call assert_refused(perion_model_create(c('bond_baced'), model), PERION_ERROR_ARGUMENT, &
        "'bond_based'")
    call assert(.not. c_associated(model), 'a refused call has made a model')
    call make_material(model, brittle=.false.)
    call assert_refused(perion_model_set(model, c('yongs_modulus'), 1.0_c_double), &
        PERION_ERROR_ARGUMENT, &
        "perion_model_set: unknown key 'yongs_modulus'; did you mean 'youngs_modulus'?")
    ! A blank at the end belongs to the name: Fortran programs trim.
    call assert_refused(perion_model_set(model, c('density '), 1.0_c_double), &
        PERION_ERROR_ARGUMENT, "'density'?")
    call assert_ok(perion_model_destroy(model))
  end subroutine misspelt_names

  subroutine values_out_of_range()
    type(c_ptr) :: model
    real(c_double) :: value

    model = c_null_ptr
    call make_material(model, brittle=.false.)
    call assert_refused(perion_model_set(model, c('density'), -1.0_c_double), &
        PERION_ERROR_ARGUMENT, "'density' is -1")
    call assert_ok(perion_model_get(model, c('density'), value))
    call assert(same_bits(value, 1.0_c_double), 'a refused value was taken')
    call assert_refused(perion_model_set(model, c('plane'), 1.0_c_double), &
        PERION_ERROR_ARGUMENT, 'takes a choice')
    call assert_ok(perion_model_destroy(model))
  end subroutine values_out_of_range

  subroutine choices_by_words()
    type(c_ptr) :: model

    model = c_null_ptr
    call make_material(model, brittle=.false.)
    call assert_ok(perion_model_choose(model, c('plane'), c('stress')))
    call assert_refused(perion_model_choose(model, c('plane'), c('strian')), &
        PERION_ERROR_ARGUMENT, "'strain'")
    call assert_refused(perion_model_choose(model, c('density'), c('low')), &
        PERION_ERROR_ARGUMENT, 'takes a number')
    call assert_refused(perion_model_choose(model, c('influence'), c('conical')), &
        PERION_ERROR_UNSUPPORTED, 'influence')
    call assert_ok(perion_model_destroy(model))
  end subroutine choices_by_words

  subroutine lists_are_complete()
    logical :: plane_seen
    integer(c_int64_t) :: place

    call assert(perion_formulation_count() >= 1, 'there is no formulation')
    call assert(text(perion_formulation_name(0_c_int64_t)) == 'bond_based', 'the first differs')
    do place = 0, perion_formulation_count() - 1
      call assert(len(text(perion_formulation_description(place))) > 20, 'no description')
    end do
    call assert(.not. c_associated(perion_formulation_name(perion_formulation_count())), &
        'there is one beyond the last')

    plane_seen = .false.
    do place = 0, perion_key_count() - 1
      call assert(c_associated(perion_key_default(place)), 'a key has no default, not even ""')
      call assert(len(text(perion_key_description(place))) > 10, 'no description')
      if (text(perion_key_name(place)) == 'plane') then
        plane_seen = .true.
        call assert(text(perion_key_choices(place)) == 'strain|stress', 'other choices')
        call assert(text(perion_key_default(place)) == 'strain', 'another default')
      else if (text(perion_key_name(place)) == 'density') then
        call assert(text(perion_key_choices(place)) == '', 'a number has choices')
      end if
    end do
    call assert(plane_seen, 'the key "plane" is not listed')
    call assert(.not. c_associated(perion_key_name(-1_c_int64_t)), 'there is a key before the first')
  end subroutine lists_are_complete

end module model_tests
