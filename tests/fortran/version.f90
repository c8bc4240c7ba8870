!> What the library says of itself: version, features, statuses and the last failure.
module version_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use testing
  implicit none
  private
  public :: test_version

contains

  subroutine test_version()
    call run('version.f90', 'the library is the one these interfaces were made for', versions_agree)
    call run('version.f90', 'features are told by name', features_are_told)
    call run('version.f90', 'every status has words of its own', statuses_have_words)
    call run('version.f90', 'the last failure stays until the next one', last_failure_stays)
  end subroutine test_version

  subroutine versions_agree()
    character(32) :: expected

    call assert(perion_version() == 10000 * PERION_VERSION_MAJOR + 100 * PERION_VERSION_MINOR &
        + PERION_VERSION_PATCH, 'the version number differs')
    call assert(perion_abi_version() == PERION_ABI_VERSION_CONSTANT, 'the binary interface differs')
    write (expected, '(i0, 2(".", i0))') PERION_VERSION_MAJOR, PERION_VERSION_MINOR, &
        PERION_VERSION_PATCH
    call assert(text(perion_version_string()) == expected, 'the version text differs')
    call assert(len(text(perion_build_info())) > 10, 'nothing is told of the build')
  end subroutine versions_agree

  subroutine features_are_told()
    call assert(has('threads'), 'threads are there')
    call assert(.not. has('ranks'), 'ranks are not there yet')
    call assert(.not. has('telepathy'), 'an unknown feature is not there')
  end subroutine features_are_told

  function has(feature)
    character(*), intent(in) :: feature
    logical :: has

    has = perion_has_feature(c(feature))
  end function has

  subroutine statuses_have_words()
    integer(c_int32_t) :: one, other

    do one = PERION_OK, PERION_ERROR_INTERNAL
      do other = PERION_OK, one - 1
        call assert(text(perion_status_string(one)) /= text(perion_status_string(other)), &
            'two statuses share their words: ' // text(perion_status_string(one)))
      end do
    end do
    call assert(text(perion_status_string(-1)) == 'unknown status', 'status -1 is none')
  end subroutine statuses_have_words

  subroutine last_failure_stays()
    integer(c_int64_t) :: count
    type(c_ptr) :: points

    call assert_refused(perion_points_count(c_null_ptr, count), PERION_ERROR_NULL, &
        "perion_points_count: argument 'points' is NULL")
    points = c_null_ptr
    call assert_ok(perion_points_create_block(2, [0.0_c_double, 0.0_c_double], &
        [2.0_c_double, 2.0_c_double], 1.0_c_double, points))
    call assert(index(text(perion_last_error()), 'perion_points_count') == 1, &
        'a success has changed the text')
    call assert_ok(perion_points_destroy(points))
  end subroutine last_failure_stays

end module version_tests
