!> Files for ParaView: single ones and series.
module files_tests
  use, intrinsic :: iso_c_binding
  use perion
  use scenes
  use testing
  implicit none
  private
  public :: test_files

  character(*), parameter :: file = 't800_files'
  integer(c_int32_t), parameter :: fields(*) = [PERION_FIELD_DISPLACEMENT, PERION_FIELD_DAMAGE]

contains

  subroutine test_files()
    call run(file, 'a file holds the fields by name', one_file)
    call run(file, 'a series lists its files in one more', series)
    call run(file, 'what cannot be written is told', unwritable)
  end subroutine test_files

  subroutine one_file()
    type(perion_simulation) :: simulation
    character(200) :: path

    call make_plate(simulation, brittle=.false.)
    path = temporary_directory // '/plate.vtu'
    call simulation%write_vtk(path, fields)
    call assert(lines_with('/plate.vtu', '<VTKFile ') == 1, 'it is no VTK file')
    call assert(lines_with('/plate.vtu', '"displacement"') == 1, 'it lacks the displacement')
    call assert(lines_with('/plate.vtu', '"damage"') == 1, 'it lacks the damage')
    call simulation%write_vtk(temporary_directory // '/bare.vtu')
    call assert(lines_with('/bare.vtu', '<VTKFile ') == 1, 'without fields it is no VTK file')
    call assert(lines_with('/bare.vtu', '"damage"') == 0, 'it has a field that nobody wanted')
    call simulation%destroy()
  end subroutine one_file

  subroutine series()
    type(perion_simulation) :: simulation
    integer :: k

    call make_plate(simulation, brittle=.true.)
    call pull(simulation)
    do k = 1, 3
      call make_steps(simulation, 10)
      call simulation%write_series(temporary_directory // '/series.pvd', fields)
    end do
    call simulation%write_series(temporary_directory // '/series.pvd')
    call assert(lines_with('/series.pvd', '<DataSet ') == 4, 'the series does not list four files')
    call assert(lines_with('/series_000002.vtu', '<VTKFile ') == 1, 'the third file is no VTK file')
    call simulation%destroy()
  end subroutine series

  subroutine unwritable()
    type(perion_simulation) :: simulation
    type(perion_error), allocatable :: error

    call make_plate(simulation, brittle=.false.)
    call simulation%write_vtk(temporary_directory // '/no/such/directory/plate.vtu', fields, error)
    call assert_fails(error, PERION_ERROR_IO, 'cannot write')
    call simulation%write_vtk(temporary_directory // '/twice.vtu', [fields(1), fields(1)], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'named twice')
    call simulation%write_vtk(temporary_directory // '/99.vtu', [99], error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, "'fields'[0] is 99")
    call simulation%write_vtk('', error=error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, 'perion_simulation_write_vtk')
    call simulation%write_series(temporary_directory // '/series.vtu', fields, error)
    call assert_fails(error, PERION_ERROR_ARGUMENT, '.pvd')
    call assert(lines_with('/twice.vtu', '') == -1, 'a refused call has written a file')
    call simulation%destroy()
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

end module files_tests
