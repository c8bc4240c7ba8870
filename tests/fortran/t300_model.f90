!> Models: numbers, choices, and the lists of what there is.
module model_tests
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: int64
  use perion
  use scenes, only: make_model
  use testing
  implicit none
  private
  public :: test_model

  character(*), parameter :: file = 't300_model'

contains

  subroutine test_model()
    call run(file, 'a number comes back with the same bits, or its default', numbers_come_back)
    call run(file, 'a misspelt name is put right', misspelt_names)
    call run(file, 'a value out of range changes nothing', values_out_of_range)
    call run(file, 'choices are made by their words', choices_by_words)
    call run(file, 'formulations and keys are listed from 1', lists_are_complete)
    call run(file, 'a refused creation leaves the model that was there', refused_creation)
  end subroutine test_model

  subroutine numbers_come_back()
    type(perion_model) :: model
    type(perion_error), allocatable :: error
    real(c_double) :: value

    call model%create('bond_based')
    value = -7
    call model%get('density', value, error)
    call assert_fails(error, PERION_ERROR_STATE, "'density' was not set")
    call assert(same_bits(value, -7d0), 'a refused call has written its output')
    call model%get('thickness', value, error)
    call assert_fine(error)
    call assert(same_bits(value, 1d0), 'the default thickness is not 1')
    call model%set('density', 0.1d0)
    call model%get('density', value)
    call assert(same_bits(value, 0.1d0), 'the density has come back another')
    call model%destroy()
    call model%get('density', value, error)
    call assert_fails(error, PERION_ERROR_NULL, 'the perion_model has not been created')
  end subroutine numbers_come_back

  subroutine misspelt_names()
    type(perion_model) :: model
    type(perion_error), allocatable :: error
    character(32) :: padded

    call model%create('bond_baced', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'bond_based'")
    call make_model(model, brittle=.false.)
    call model%set('yongs_modulus', 1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, &
        "perion_model_set: unknown key 'yongs_modulus'; did you mean 'youngs_modulus'?")
    padded = 'density'
    call model%set(padded, 2d0, error)
    call assert_fine(error)
    call model%set('', 2d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'perion_model_set')
    call model%destroy()
  end subroutine misspelt_names

  subroutine values_out_of_range()
    type(perion_model) :: model
    type(perion_error), allocatable :: error
    real(c_double) :: value

    call make_model(model, brittle=.false.)
    call model%set('density', -1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'density' is -1")
    call model%set('density', infinity(), error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'density' is inf")
    call model%get('density', value)
    call assert(same_bits(value, 1d0), 'a refused value was taken')
    call model%set('plane', 1d0, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'takes a choice')
    call model%get('plane', value, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'holds a choice')
    call model%destroy()
  end subroutine values_out_of_range

  subroutine choices_by_words()
    type(perion_model) :: model
    type(perion_error), allocatable :: error

    call make_model(model, brittle=.false.)
    call model%choose('plane', 'stress')
    call model%choose('plane', 'strian', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'strain'")
    call model%choose('density', 'low', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'takes a number')
    call model%choose('influence', 'conical', error)
    call assert_fails(error, PERION_ERROR_UNSUPPORTED, 'influence')
    call model%destroy()
    call model%choose('plane', 'stress', error)
    call assert_fails(error, PERION_ERROR_NULL, 'the perion_model has not been created')
  end subroutine choices_by_words

  subroutine lists_are_complete()
    logical :: plane_seen
    integer :: place
    integer(int64) :: wide

    call assert(perion_formulation_count() >= 1, 'there is no formulation')
    call assert(perion_formulation_name(1) == 'bond_based', 'the first differs')
    call assert(perion_formulation_name(1_int64) == 'bond_based', 'the first differs for 64 bits')
    do place = 1, perion_formulation_count()
      wide = place
      call assert(len(perion_formulation_description(place)) > 20, 'no description')
      call assert(perion_formulation_description(place) == perion_formulation_description(wide), &
          'the descriptions differ')
    end do
    call assert(perion_formulation_name(perion_formulation_count() + 1) == '', &
        'there is one beyond the last')

    plane_seen = .false.
    do place = 1, perion_key_count()
      wide = place
      call assert(len(perion_key_description(place)) > 10, 'no description')
      call assert(perion_key_name(place) == perion_key_name(wide), 'the names differ')
      call assert(perion_key_description(place) == perion_key_description(wide), 'the meanings differ')
      call assert(perion_key_default(place) == perion_key_default(wide), 'the defaults differ')
      call assert(perion_key_choices(place) == perion_key_choices(wide), 'the choices differ')
      if (perion_key_name(place) == 'plane') then
        plane_seen = .true.
        call assert(perion_key_choices(place) == 'strain|stress', 'other choices')
        call assert(perion_key_default(place) == 'strain', 'another default')
      else if (perion_key_name(place) == 'density') then
        call assert(len(perion_key_choices(place)) == 0, 'a number has choices')
      end if
    end do
    call assert(plane_seen, 'the key plane is not listed')
    call assert(len(perion_key_name(0)) == 0, 'there is a key before the first')
    call assert(len(perion_key_name(-huge(1_int64) - 1)) == 0, 'there is a key far before the first')
    call assert(len(perion_key_name(huge(1_int64))) == 0, 'there is a key far beyond the last')
  end subroutine lists_are_complete

  subroutine refused_creation()
    type(perion_model) :: model
    type(perion_error), allocatable :: error
    real(c_double) :: value

    call make_model(model, brittle=.false.)
    call model%create('state_biased', error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'perion_model_create')
    call model%get('density', value)
    call assert(same_bits(value, 1d0), 'the model has changed')
    call model%create('bond_based')
    call model%get('density', value, error)
    call assert_fails(error, PERION_ERROR_STATE, 'was not set')
    call model%destroy()
    call model%destroy()
  end subroutine refused_creation

end module model_tests
