!> Lists and sections of many points. On a small stack copies of them would end the program, which
!> itself keeps what is large on the heap.
program stack
  use, intrinsic :: iso_c_binding, only: c_double, c_int64_t
  use perion
  implicit none
  integer, parameter :: along = 300, n = along**2

  type(perion_points) :: points
  type(perion_model) :: model
  type(perion_simulation) :: simulation
  integer, allocatable :: list(:, :), bonds(:, :)
  integer(c_int64_t), allocatable :: wide(:, :), wide_bonds(:, :)
  real(c_double), allocatable :: host(:, :), stretch(:, :)
  integer :: k, bond_count

  ! Of each point: x, nothing, y, volume, horizon, number; and the bond to the next one.
  allocate (host(6, n), list(3, n - 1), wide(3, n - 1))
  do k = 1, n
    host(:, k) = [mod(k - 1, along) + 0.5d0, -7d0, (k - 1) / along + 0.5d0, 1d0, 2d0, real(k, c_double)]
  end do
  do k = 1, n - 1
    list(:, k) = [k, -7, k + 1]
    wide(:, k) = list(:, k)
  end do

  call points%create(host(1:3:2, :), host(4, :))
  call points%set_horizons(host(5, :))
  call points%add_set('narrow', list(1, :))
  call points%add_set('wide', wide(3, :))
  call points%get_set('narrow', list(3, :))
  call points%get_set('wide', wide(1, :))
  call assert(all(list(3, :) + 1 == wide(1, :)), 'sets')
  call points%get_coordinates(host(3:1:-2, :))
  call points%get_coordinates(host(1:2, :))
  call points%get_volumes(host(3, :))
  call assert(abs(host(1, 2) - 1.5d0) <= 0 .and. all(abs(host(3, :) - 1) <= 0), 'points')

  call model%create('bond_based')
  call model%set('density', 1d0)
  call model%set('youngs_modulus', 1d0)
  call model%set('horizon', 2d0)
  call simulation%create(points, model)
  host(5, :) = 0.5d0
  list(3, :) = list(1, :) + 1
  wide(1:2, :) = list(2:3, :) - 1
  wide(1, :) = list(1, :)
  wide(3, :) = list(3, :)
  call simulation%set_bond_integrity(list(1:3:2, :), host(5, :n - 1))
  call simulation%set_bond_integrity(wide(1:3:2, :), host(5, :n - 1))
  call simulation%break_bonds(list(3:1:-2, :))
  call simulation%break_bonds(wide(3:1:-2, :))
  call simulation%bond_count(bond_count)
  allocate (bonds(3, bond_count), wide_bonds(3, bond_count), stretch(2, bond_count))
  call simulation%get_bonds(bonds(1:3:2, :), stretch(1, :), stretch(2, :))
  call simulation%get_bonds(wide_bonds(1:3:2, :))
  call assert(all(bonds(3, :) == wide_bonds(3, :)), 'bonds')

  call simulation%prescribe_table('all', PERION_QUANTITY_VELOCITY, 1, host(6, :), host(5, :))
  call simulation%prescribe_values('all', PERION_QUANTITY_BODY_FORCE, 2, host(5, :))
  call simulation%set(PERION_FIELD_DISPLACEMENT, host(1:4:3, :))
  call simulation%get(PERION_FIELD_DISPLACEMENT, host(2:6:4, :))
  call simulation%get(PERION_FIELD_VOLUME, host(6, :))
  call assert(all(abs(host(2, :) - host(1, :)) <= 0), 'fields')
  print '(a)', 'done'

contains

  subroutine assert(holds, what)
    logical, intent(in) :: holds
    character(*), intent(in) :: what

    if (.not. holds) error stop what
  end subroutine assert

end program stack
