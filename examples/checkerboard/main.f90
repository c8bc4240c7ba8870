!> A checkerboard of displacements: which formulations see it, and what it costs in each.
!>
!> Points of a cube of steel are displaced so that the sign changes from point to point, by a thousandth
!> of their spacing: Partmann et al. 2026, section 4.4. A gradient averaged over a family does not see
!> such a mode, and the correspondence formulations store no energy in it, not even where a penalty
!> resists it. The bond-associated quadrature and bonds themselves do see it. The window in the middle,
!> 40 points along an edge in the paper, is two horizons from every face: all families that count there
!> are full.
!>
!> Usage: checkerboard [points along the window, 16] [profile, checkerboard_fortran.csv]
!>                     [output files, checkerboard_fortran]
!>
!> In order: points, then for each formulation: model, simulation, a state set by hand, its fields, a
!> file. Nothing moves. Units are m, s and kg. The same program stands beside this one in C and in Rust;
!> all three print the same hash.
module checkerboard_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  implicit none
  private
  public :: hash_values, write_profile

  !> A formulation with its influence function.
  type, public :: form
    character(26) :: formulation
    character(12) :: influence
  end type form

contains

  !> A row for each point on the line through the middle and a column for each formulation; the first
  !> line names them.
  subroutine write_profile(path, forms, profiles, spacing)
    character(*), intent(in) :: path
    type(form), intent(in) :: forms(:)
    real(real64), intent(in) :: profiles(:, :), spacing
    integer :: unit, k, points

    points = size(profiles, 1)
    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(*(a))') 'x (m)', (',' // trim(forms(k)%formulation) // ' ' &
        // trim(forms(k)%influence) // ' (kJ/m3)', k=1, size(forms))
    do k = 1, points
      write (unit, '(f8.4, ",", *(f11.5, :, ","))') (k - 1 - points / 2) * spacing, &
          1d-3 * profiles(k, :)
    end do
    close (unit)
  end subroutine write_profile

  !> Goes on with a fingerprint of the bits of numbers.
  subroutine hash_values(hash, values)
    integer(int64), intent(inout) :: hash
    real(real64), intent(in) :: values(:)
    integer(int64), parameter :: factor = 65599, modulus = 1099511627689_int64
    integer(int64), parameter :: lower_half = int(z'ffffffff', int64)
    integer(int64) :: bits
    integer :: k

    do k = 1, size(values)
      bits = transfer(values(k), bits)
      hash = mod(hash * factor + iand(bits, lower_half), modulus)
      hash = mod(hash * factor + shiftr(bits, 32), modulus)
    end do
  end subroutine hash_values

end module checkerboard_host

program checkerboard
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use checkerboard_host
  implicit none

  real(real64), parameter :: pi = 3.14159265358979323846d0
  real(real64), parameter :: spacing = 0.025d0             ! m
  real(real64), parameter :: horizon = 3.015d0 * spacing   ! m
  real(real64), parameter :: amplitude = 1d-3 * spacing    ! m
  !> Layers of points around the window: families reach three, and those of neighbours three more.
  integer, parameter :: buffer = 6
  type(form), parameter :: forms(7) = [ &
      form('correspondence', 'constant'), &
      form('correspondence_silling', 'constant'), &
      form('correspondence_wan', 'constant'), &
      form('bond_associated_quadrature', 'constant'), &
      form('bond_associated_quadrature', 'inverse'), &
      form('bond_associated_quadrature', 'cubic_spline'), &
      form('bond_based', '')]

  type(perion_points) :: points
  type(perion_model) :: steel
  type(perion_simulation) :: body
  character(500) :: first_argument, profile, files
  character(:), allocatable :: path
  integer :: window, edge, middle, first, last, count, flaw, k
  integer(int64) :: hash
  real(real64) :: face, far_face
  real(real64), allocatable :: wave(:, :), displacement(:, :), profiles(:, :)
  real(real64), allocatable, target :: energy(:), penalty(:)
  real(real64), pointer :: energies(:, :, :), penalties(:, :, :)

  window = 16
  profile = 'checkerboard_fortran.csv'
  files = 'checkerboard_fortran'
  flaw = 0
  call get_command_argument(1, first_argument)
  if (command_argument_count() > 0) read (first_argument, *, iostat=flaw) window
  if (command_argument_count() > 1) call get_command_argument(2, profile)
  if (command_argument_count() > 2) call get_command_argument(3, files)
  if (flaw /= 0 .or. window < 2) then
    write (error_unit, '(a)') 'at least 2 points along the window are needed'
    stop 1, quiet=.true.
  end if
  edge = window + 2 * buffer
  middle = edge / 2 + 1
  first = buffer + 1
  last = buffer + window

  ! The points: a block that is shifted by half a spacing, so that coordinates are whole spacings.
  face = -(edge / 2 + 0.5d0) * spacing
  far_face = face + edge * spacing
  call points%create_block([face, face, face], [far_face, far_face, far_face], spacing)
  call points%count(count)
  print '(i0, a, i0, a)', count, ' points, ', window, ' along the window'

  ! The displacement: each component alternates along the other two axes.
  allocate (wave(3, count), displacement(3, count))
  call points%get_coordinates(wave)
  wave = cos(pi * wave / spacing)
  displacement(1, :) = amplitude * wave(2, :) * wave(3, :)
  displacement(2, :) = amplitude * wave(1, :) * wave(3, :)
  displacement(3, :) = amplitude * wave(1, :) * wave(2, :)

  print '(a)', 'strain energy density in the window (kJ/m3)                     penalty'
  print '(a)', '                                          middle     least  greatest    middle'
  hash = 0
  allocate (energy(count), penalty(count), profiles(edge, size(forms)))
  ! The points of a block as an array: x runs fastest, then y.
  energies(1:edge, 1:edge, 1:edge) => energy
  penalties(1:edge, 1:edge, 1:edge) => penalty
  do k = 1, size(forms)
    call steel%create(trim(forms(k)%formulation))
    call steel%set('youngs_modulus', 210d9)   ! Pa
    call steel%set('density', 8000d0)         ! kg/m3
    call steel%set('horizon', horizon)
    path = trim(files) // '_' // trim(forms(k)%formulation)
    ! Bonds alone have Poisson's ratio 1/4, and no influence function.
    if (forms(k)%influence /= '') then
      call steel%set('poissons_ratio', 0.25d0)
      call steel%choose('influence', trim(forms(k)%influence))
      path = path // '_' // trim(forms(k)%influence)
    end if

    call body%create(points, steel)
    call body%set(PERION_FIELD_DISPLACEMENT, displacement)
    call body%get(PERION_FIELD_STRAIN_ENERGY_DENSITY, energy)
    call body%get(PERION_FIELD_STABILIZATION_ENERGY_DENSITY, penalty)
    if (files /= '') call body%write_vtk(path // '.vtu', [PERION_FIELD_STRAIN_ENERGY_DENSITY, &
        PERION_FIELD_STABILIZATION_ENERGY_DENSITY, PERION_FIELD_DISPLACEMENT])
    call body%destroy()
    call steel%destroy()

    profiles(:, k) = energies(:, middle, middle)
    associate (inside => energies(first:last, first:last, first:last))
      print '(a, 1x, a, 4(f9.4, :, 1x))', forms(k)%formulation, forms(k)%influence, &
          1d-3 * energies(middle, middle, middle), 1d-3 * minval(inside), 1d-3 * maxval(inside), &
          1d-3 * penalties(middle, middle, middle)
    end associate
    call hash_values(hash, energy)
    call hash_values(hash, penalty)
  end do
  print '(a, z10.10)', 'hash            ', hash
  if (profile /= '') call write_profile(profile, forms, profiles, spacing)

  call points%destroy()
end program checkerboard
