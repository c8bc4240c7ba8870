!> What the library says of itself: version, features, statuses and the last failure.
module version_tests
  use, intrinsic :: iso_c_binding
  use perion
  use testing
  implicit none
  private
  public :: test_version

  character(*), parameter :: file = 't100_version'

contains

  subroutine test_version()
    call run(file, 'the library is the one that this module was made for', versions_agree)
    call run(file, 'features are told by name', features_are_told)
    call run(file, 'every status has words of its own', statuses_have_words)
    call run(file, 'the last failure stays until the next one', last_failure_stays)
  end subroutine test_version

  subroutine versions_agree()
    character(32) :: expected

    call assert(perion_version() == 10000 * PERION_VERSION_MAJOR + 100 * PERION_VERSION_MINOR &
        + PERION_VERSION_PATCH, 'the version number differs')
    call assert(perion_abi_version() == PERION_ABI_VERSION_CONSTANT, 'the binary interface differs')
    write (expected, '(i0, 2(".", i0))') PERION_VERSION_MAJOR, PERION_VERSION_MINOR, &
        PERION_VERSION_PATCH
    call assert(perion_version_string() == expected, 'the version text differs')
    call assert(len(perion_build_info()) > 10, 'nothing is told of the build')
  end subroutine versions_agree

  subroutine features_are_told()
    call assert(perion_has_feature('threads'), 'threads are there')
    call assert(perion_has_feature('threads   '), 'blanks at the end count')
    call assert(.not. perion_has_feature('ranks'), 'ranks are not there yet')
    call assert(.not. perion_has_feature(''), 'no feature is not there')
  end subroutine features_are_told

  subroutine statuses_have_words()
    integer(c_int32_t) :: one, other

    do one = PERION_OK, PERION_ERROR_INTERNAL
      do other = PERION_OK, one - 1
        call assert(perion_status_string(one) /= perion_status_string(other), &
            'two statuses share their words: ' // perion_status_string(one))
      end do
    end do
    call assert(perion_status_string(-1) == 'unknown status', 'status -1 is none')
  end subroutine statuses_have_words

  subroutine last_failure_stays()
    type(perion_points) :: points
    type(perion_error), allocatable :: error
    integer :: count

    call points%count(count, error)
    call assert_fails(error, PERION_ERROR_NULL, &
        'perion_points_count: the perion_points has not been created')
    call points%create_block([0d0, 0d0], [2d0, 2d0], 1d0, error)
    call assert_fine(error)
    call assert(index(perion_last_error(), 'perion_points_count') == 1, &
        'a success has changed the text')
    call points%destroy()
  end subroutine last_failure_stays

end module version_tests
