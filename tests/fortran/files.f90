!> Files for ParaView: single ones and series.
module file_tests
  use, intrinsic :: iso_c_binding
  use perion_c
  use scenes
  use testing
  implicit none
  private
  public :: test_files

  character(*), parameter :: file = 'files.f90'
  integer(c_int32_t), parameter :: fields(*) = [PERION_FIELD_DISPLACEMENT, PERION_FIELD_DAMAGE]
  integer(c_int64_t), parameter :: field_count = size(fields)

contains

  subroutine test_files()
    call run(file, 'a file holds the fields by name', one_file)
    call run(file, 'a series lists its files in one more', series)
    call run(file, 'what cannot be written is told', unwritable)
  end subroutine test_files

  subroutine one_file()
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_ok(perion_simulation_write_vtk(simulation, &
        c(temporary_directory // '/plate.vtu'), field_count, fields))
    call assert(lines_with('/plate.vtu', '<VTKFile ') == 1, 'it is no VTK file')
    call assert(lines_with('/plate.vtu', '"displacement"') == 1, 'it lacks the displacement')
    call assert(lines_with('/plate.vtu', '"damage"') == 1, 'it lacks the damage')
    call destroy(simulation)
  end subroutine one_file

  subroutine series()
    type(c_ptr) :: simulation
    integer :: k

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    do k = 1, 3
      call make_steps(simulation, 10)
      call assert_ok(perion_simulation_write_series(simulation, &
          c(temporary_directory // '/series.pvd'), field_count, fields))
    end do
    call assert(lines_with('/series.pvd', '<DataSet ') == 3, 'the series does not list three files')
    call assert(lines_with('/series_000002.vtu', '<VTKFile ') == 1, 'the third file is no VTK file')
    call destroy(simulation)
  end subroutine series

  subroutine unwritable()
    type(c_ptr) :: simulation

    simulation = c_null_ptr
    call make_plate(simulation, brittle=.false.)
    call assert_refused(perion_simulation_write_vtk(simulation, &
        c(temporary_directory // '/no/such/directory/plate.vtu'), field_count, fields), &
        PERION_ERROR_IO, 'cannot write')
    call assert_refused(perion_simulation_write_vtk(simulation, &
        c(temporary_directory // '/twice.vtu'), 2_c_int64_t, [fields(1), fields(1)]), &
        PERION_ERROR_ARGUMENT, 'named twice')
    call assert_refused(perion_simulation_write_series(simulation, &
        c(temporary_directory // '/series.vtu'), field_count, fields), PERION_ERROR_ARGUMENT, '.pvd')
    call destroy(simulation)
  end subroutine unwritable

  !> Number of lines with these words in a file, as far as it is text; -1 when it is not there.
  function lines_with(path, words) result(lines)
    character(*), intent(in) :: path, words
    integer :: lines
    character(1000) :: line
    integer :: unit, flaw

    lines = -1
    open (newunit=unit, file=temporary_directory // path, status='old', action='read', iostat=flaw)
    if (flaw /= 0) return
    lines = 0
    do
      read (unit, '(a)', iostat=flaw) line
      if (flaw /= 0) exit
      if (index(line, words) > 0) lines = lines + 1
    end do
    close (unit)
  end function lines_with

end module file_tests
