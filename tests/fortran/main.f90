!> Runs all tests of the module. Argument: a directory to write files to.
program fortran_tests
  use, intrinsic :: ieee_arithmetic
  use balance_tests, only: test_balance
  use bonds_tests, only: test_bonds
  use callback_tests, only: test_callbacks
  use conditions_tests, only: test_conditions
  use drive_tests, only: test_drive
  use fields_tests, only: test_fields
  use files_tests, only: test_files
  use host_floats_tests, only: test_host_floats
  use life_cycle_tests, only: test_life_cycle
  use material_tests, only: test_material
  use model_tests, only: test_model
  use points_tests, only: test_points
  use raw_tests, only: test_raw
  use setup_tests, only: test_setup
  use statics_tests, only: test_statics
  use testing, only: finish, temporary_directory
  use version_tests, only: test_version
  use views_tests, only: test_views
  implicit none
  logical :: halting(size(ieee_usual))
  integer :: length

  call get_command_argument(1, length=length)
  allocate (character(length) :: temporary_directory)
  call get_command_argument(1, temporary_directory)
  ! Valgrind knows no traps; everywhere else the compiler was told to set them.
  call ieee_get_halting_mode(ieee_usual, halting)
  print '(2a)', 'traps ', merge('on ', 'off', all(halting))

  call test_raw()
  call test_version()
  call test_points()
  call test_model()
  call test_material()
  call test_setup()
  call test_bonds()
  call test_conditions()
  call test_fields()
  call test_views()
  call test_drive()
  call test_statics()
  call test_balance()
  call test_files()
  call test_callbacks()
  call test_host_floats()
  call test_life_cycle()
  call finish()
end program fortran_tests
