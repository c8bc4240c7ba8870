!> A plate of glass cracks and branches: the boundary tension test of Partmann et al. 2026, section 5.3.
!>
!> A plate of 100 x 40 x 4 mm has a crack from its left edge to its centre. At time 0 a tension of 1 MPa
!> is put on its upper and lower edge and held. The crack starts to run and splits in two.
!>
!> Usage: branching [points along the plate, 200] [output file, branching_fortran.pvd]
!>
!> What a host program does with Perion, in order: points, sets, model, simulation, conditions, step,
!> results. The same program stands beside this one in C and in Rust; all three print the same hash,
!> because the results are the same to the last bit.
!>
!> `perion_c` declares the C interface as it is: handles are `type(c_ptr)`, text ends in `c_null_char`,
!> axes and indices start at 0, and every call that can fail is a function that gives a status.
module branching_host
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, output_unit
  use perion_c
  implicit none
  private
  public :: argument, check, hash_field, scientific, seconds, show_progress, three_digits, watch

  !> What the progress callback below needs.
  type :: watch
    type(c_ptr) :: simulation = c_null_ptr
    character(:), allocatable :: series
    real(c_double) :: start = 0
    integer(int64) :: shown = 0
  end type watch

  interface
    !> Of the C library: the length of a text.
    pure function strlen(text) bind(c)
      import :: c_ptr, c_size_t
      type(c_ptr), value, intent(in) :: text
      integer(c_size_t) :: strlen
    end function strlen
  end interface

contains

  !> Every call that can fail returns a status; the text says what went wrong and what to do.
  subroutine check(status)
    integer(c_int32_t), intent(in) :: status

    if (status == PERION_OK) return
    call complain(status)
    stop 1, quiet=.true.
  end subroutine check

  subroutine complain(status)
    integer(c_int32_t), intent(in) :: status

    write (error_unit, '(3a)') text(perion_status_string(status)), ': ', text(perion_last_error())
  end subroutine complain

  !> A text of C as one of Fortran.
  function text(pointer)
    type(c_ptr), intent(in) :: pointer
    character(:), allocatable :: text
    character(kind=c_char), pointer :: letters(:)
    integer :: place

    call c_f_pointer(pointer, letters, [strlen(pointer)])
    allocate (character(size(letters)) :: text)
    do place = 1, size(letters)
      text(place:place) = letters(place)
    end do
  end function text

  !> Perion calls this after each step. It may look at the simulation and write files; a result other
  !> than 0 stops the run. It must come back to Perion: no `stop` and no `error stop` in here.
  function show_progress(user, done, total, time) bind(c) result(stop_now)
    type(c_ptr), value :: user
    integer(c_int64_t), value :: done, total
    real(c_double), value :: time
    integer(c_int) :: stop_now
    integer(c_int32_t), parameter :: fields(*) = [PERION_FIELD_DAMAGE, PERION_FIELD_DISPLACEMENT, &
        PERION_FIELD_VELOCITY, PERION_FIELD_STRAIN_ENERGY_DENSITY]
    type(watch), pointer :: watching
    integer(c_int32_t) :: status
    real(c_double) :: elapsed

    call c_f_pointer(user, watching)
    stop_now = 0
    if (20 * done / total == watching%shown) return
    watching%shown = 20 * done / total
    if (len(watching%series) > 0) then
      status = perion_simulation_write_series(watching%simulation, watching%series // c_null_char, &
          size(fields, kind=c_int64_t), fields)
      if (status /= PERION_OK) then
        call complain(status)
        stop_now = 1
        return
      end if
    end if
    elapsed = seconds() - watching%start
    write (output_unit, '(a, i5, a, i0, 4a)') 'step ', done, ' of ', total, ', ', &
        tenths(1e6_c_double * time, 5) // ' us, ', &
        tenths(elapsed * real(total - done, c_double) / real(done, c_double), 6), ' s left'
    flush (output_unit)
  end function show_progress

  !> Seconds since some moment in the past.
  function seconds()
    real(c_double) :: seconds
    integer(int64) :: ticks, ticks_per_second

    call system_clock(ticks, ticks_per_second)
    seconds = real(ticks, c_double) / real(ticks_per_second, c_double)
  end function seconds

  !> A fingerprint of the bits of a field.
  function hash_field(hash, simulation, field, length) result(next)
    integer(int64), intent(in) :: hash
    type(c_ptr), intent(in) :: simulation
    integer(c_int32_t), intent(in) :: field
    integer(c_int64_t), intent(in) :: length
    integer(int64), parameter :: factor = 65599, modulus = 1099511627689_int64
    integer(int64), parameter :: lower_half = int(z'ffffffff', int64)
    integer(int64) :: next, bits, k
    real(c_double), allocatable :: values(:)

    allocate (values(length))
    call check(perion_simulation_get(simulation, field, values, length))
    next = hash
    do k = 1, length
      bits = transfer(values(k), bits)
      next = mod(next * factor + iand(bits, lower_half), modulus)
      next = mod(next * factor + shiftr(bits, 32), modulus)
    end do
  end function hash_field

  !> An argument of the command line, or its default.
  function argument(number, default)
    integer, intent(in) :: number
    character(*), intent(in) :: default
    character(:), allocatable :: argument
    integer :: length

    if (number > command_argument_count()) then
      argument = default
    else
      call get_command_argument(number, length=length)
      allocate (character(length) :: argument)
      call get_command_argument(number, argument)
    end if
  end function argument

  !> With one decimal, in `width` columns or as many as it needs: %5.1f of C.
  function tenths(value, width)
    real(c_double), intent(in) :: value
    integer, intent(in) :: width
    character(:), allocatable :: tenths
    character(32) :: buffer

    write (buffer, '(f32.1)') value
    tenths = trim(adjustl(buffer))
    tenths = repeat(' ', max(0, width - len(tenths))) // tenths
  end function tenths

  !> With an exponent and so many decimals: %.6e of C.
  function scientific(value, decimals)
    real(c_double), intent(in) :: value
    integer, intent(in) :: decimals
    character(:), allocatable :: scientific
    character(32) :: buffer, form

    write (form, '(a, i0, a)') '(es32.', decimals, ')'
    write (buffer, form) value
    scientific = trim(adjustl(buffer))
    associate (letter => scan(scientific, 'E'))
      if (letter > 0) scientific(letter:letter) = 'e'
    end associate
  end function scientific

  !> With three digits and no zeros at the end: %.3g of C, for 0.0001 to 999.
  function three_digits(value)
    real(c_double), intent(in) :: value
    character(:), allocatable :: three_digits
    character(32) :: buffer, form
    integer :: exponent

    write (buffer, '(es32.2)') value
    read (buffer(index(buffer, 'E') + 1:), '(i4)') exponent
    write (form, '(a, i0, a)') '(f32.', 2 - exponent, ')'
    write (buffer, form) value
    three_digits = trim(adjustl(buffer))
    three_digits = three_digits(:verify(three_digits, '0', back=.true.))
    if (index(three_digits, '.') == len(three_digits)) then
      three_digits = three_digits(:len(three_digits) - 1)
    end if
  end function three_digits

end module branching_host

program branching
  use, intrinsic :: iso_c_binding
  use, intrinsic :: iso_fortran_env, only: error_unit, int64
  use branching_host
  use perion_c
  implicit none

  real(c_double), parameter :: length = 0.1_c_double, height = 0.04_c_double  ! metres
  real(c_double), parameter :: depth = 0.004_c_double
  real(c_double), parameter :: end_time = 50e-6_c_double  ! seconds
  real(c_double), parameter :: traction = 1e6_c_double  ! pascals
  ! A rectangle, corner by corner, from the left edge to the centre of the plate.
  real(c_double), parameter :: crack(3, 4) = reshape([0.0_c_double, 0.0_c_double, 0.0_c_double, &
      length / 2, 0.0_c_double, 0.0_c_double, length / 2, 0.0_c_double, depth, &
      0.0_c_double, 0.0_c_double, depth], [3, 4])

  type(c_ptr) :: points = c_null_ptr, glass = c_null_ptr, simulation = c_null_ptr
  type(perion_energy) :: energy
  type(perion_health) :: health
  type(watch), target :: watching
  character(:), allocatable :: along_text
  character(10) :: hash_text
  integer :: along, flaw, k
  integer(c_int64_t) :: count, steps
  integer(int64) :: hash
  real(c_double) :: spacing, lower(3), upper(3), below_top(3), above_bottom(3), body_force, stable

  along_text = argument(1, '200')
  watching%series = argument(2, 'branching_fortran.pvd')
  read (along_text, '(i10)', iostat=flaw) along
  if (flaw /= 0) along = 0
  deallocate (along_text)
  if (along < 10) then
    write (error_unit, '(a)') 'at least 10 points along the plate are needed'
    stop 1, quiet=.true.
  end if

  ! The points: a block, its lower left corner in the middle of the left edge. One layer of points
  ! along the upper edge and one along the lower are named, to pull on them.
  spacing = length / along
  lower = [0.0_c_double, -height / 2, 0.0_c_double]
  upper = [length, height / 2, depth]
  below_top = [0.0_c_double, height / 2 - spacing, 0.0_c_double]
  above_bottom = [length, spacing - height / 2, depth]
  call check(perion_points_create_block(3, lower, upper, spacing, points))
  call check(perion_points_add_set_box(points, 'top' // c_null_char, below_top, upper))
  call check(perion_points_add_set_box(points, 'bottom' // c_null_char, lower, above_bottom))
  call check(perion_points_count(points, count))

  ! The material: soda-lime glass. Bond-based peridynamics takes one elastic constant, since its
  ! Poisson's ratio is 1/4. The energy release rate tells when bonds break.
  call check(perion_model_create('bond_based' // c_null_char, glass))
  call check(perion_model_set(glass, 'youngs_modulus' // c_null_char, 32e9_c_double))
  call check(perion_model_set(glass, 'density' // c_null_char, 2440.0_c_double))
  call check(perion_model_set(glass, 'horizon' // c_null_char, 3.015_c_double * spacing))
  call check(perion_model_set(glass, 'critical_energy_release_rate' // c_null_char, 0.75_c_double))

  ! The simulation keeps copies, so points and model can go.
  call check(perion_simulation_create(points, glass, simulation))
  call check(perion_points_destroy(points))
  call check(perion_model_destroy(glass))

  ! The crack that is there from the start: all bonds across it are broken.
  call check(perion_simulation_break_crossing(simulation, size(crack, 2, c_int64_t), crack))

  ! The tension, as a body force along the second axis (1 in C) on the named layers, whose bonds may
  ! not break.
  body_force = traction / spacing
  call check(perion_simulation_prescribe(simulation, 'top' // c_null_char, &
      PERION_QUANTITY_BODY_FORCE, 1, body_force))
  call check(perion_simulation_prescribe(simulation, 'bottom' // c_null_char, &
      PERION_QUANTITY_BODY_FORCE, 1, -body_force))
  call check(perion_simulation_forbid_failure(simulation, 'top' // c_null_char))
  call check(perion_simulation_forbid_failure(simulation, 'bottom' // c_null_char))

  ! Stepping: the library knows a step that is stable.
  call check(perion_simulation_stable_time_step(simulation, stable))
  steps = ceiling(end_time / stable, c_int64_t)
  print '(i0, a, i0, 3a)', count, ' points, ', steps, ' steps of ', &
      three_digits(1e6_c_double * end_time / real(steps, c_double)), ' us'
  watching%simulation = simulation
  watching%start = seconds()
  call check(perion_simulation_set_progress(simulation, c_funloc(show_progress), c_loc(watching)))
  call check(perion_simulation_step(simulation, end_time / real(steps, c_double), steps))

  ! Results.
  call perion_energy_init(energy, c_sizeof(energy))
  call perion_health_init(health, c_sizeof(health))
  call check(perion_simulation_energy(simulation, energy))
  call check(perion_simulation_health(simulation, health))
  print '(a, i0, a, i0)', 'broken bonds    ', health%broken_bonds, ' of ', health%bonds
  print '(3a)', 'external work   ', scientific(energy%external_work, 6), ' J'
  print '(3a)', 'kinetic energy  ', scientific(energy%kinetic, 6), ' J'
  print '(3a)', 'elastic energy  ', scientific(energy%elastic, 6), ' J'
  print '(3a)', 'dissipated      ', scientific(energy%dissipated, 6), ' J'
  print '(3a)', 'closure error   ', scientific(energy%closure_error / energy%external_work, 2), &
      ' of the work'
  hash = hash_field(0_int64, simulation, PERION_FIELD_DISPLACEMENT, 3 * count)
  hash = hash_field(hash, simulation, PERION_FIELD_VELOCITY, 3 * count)
  hash = hash_field(hash, simulation, PERION_FIELD_DAMAGE, count)
  write (hash_text, '(z10.10)') hash
  do k = 1, len(hash_text)  ! Letters in lower case.
    if (hash_text(k:k) >= 'A') hash_text(k:k) = achar(iachar(hash_text(k:k)) + 32)
  end do
  print '(2a)', 'hash            ', hash_text

  call check(perion_simulation_destroy(simulation))
end program branching
