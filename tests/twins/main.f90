!> Every formulation on one small body, and a fingerprint of all bits there are after some steps. The same
!> program stands beside this one in C and in Rust. All numbers that go in are exact in binary.
program twins
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none

  integer, parameter :: count = 5 * 4 * 3, steps = 5
  integer :: index

  do index = 1, int(perion_formulation_count())
    call run(perion_formulation_name(index))
  end do

contains

  subroutine make_cloud(points)
    type(perion_points), intent(inout) :: points
    real(real64) :: coordinates(3, count), volumes(count)
    integer :: axis, jitter, place(3), point

    do point = 0, count - 1
      place = [mod(point, 5), mod(point / 5, 4), point / 20]
      do axis = 0, 2
        jitter = mod(point * 7919 + axis * 104729, 257) - 128
        coordinates(axis + 1, point + 1) = (1024 * place(axis + 1) + jitter) / 1024d0
      end do
      volumes(point + 1) = (896 + mod(point * 31, 256)) / 1024d0
    end do
    call points%create(coordinates, volumes)
    call points%add_set_box('left', [-1d0, -1d0, -1d0], [0.5d0, 9d0, 9d0])
    call points%add_set_box('right', [3.5d0, -1d0, -1d0], [9d0, 9d0, 9d0])
  end subroutine make_cloud

  subroutine run(formulation)
    character(*), intent(in) :: formulation
    type(perion_points) :: points
    type(perion_model) :: model
    type(perion_simulation) :: simulation
    type(perion_health) :: health
    real(real64) :: vector(3, count), scalar(count)
    integer(int64) :: hash
    integer :: axis, point

    call make_cloud(points)
    call model%create(formulation)
    call model%set('density', 1.25d0)
    call model%set('youngs_modulus', 1.5d0)
    call model%set('poissons_ratio', 0.25d0)
    call model%set('horizon', 2.25d0)
    call model%set('critical_stretch', 1d0 / 128)
    call simulation%create(points, model)
    do point = 0, count - 1
      do axis = 0, 2
        vector(axis + 1, point + 1) = (mod((3 * point + axis) * 13, 64) - 32) / 1024d0
      end do
    end do
    call simulation%set(PERION_FIELD_VELOCITY, vector)
    call simulation%prescribe('left', PERION_QUANTITY_VELOCITY, 1, -1d0 / 64)
    call simulation%prescribe('right', PERION_QUANTITY_VELOCITY, 1, 1d0 / 64)
    call simulation%step(1d0 / 16, steps)
    hash = 0
    call simulation%get(PERION_FIELD_DISPLACEMENT, vector)
    call hash_values(hash, 3 * count, vector)
    call simulation%get(PERION_FIELD_VELOCITY, vector)
    call hash_values(hash, 3 * count, vector)
    call simulation%get(PERION_FIELD_INTERNAL_FORCE, vector)
    call hash_values(hash, 3 * count, vector)
    call simulation%get(PERION_FIELD_STRAIN_ENERGY_DENSITY, scalar)
    call hash_values(hash, count, scalar)
    call simulation%get(PERION_FIELD_VON_MISES_STRESS, scalar)
    call hash_values(hash, count, scalar)
    call simulation%get(PERION_FIELD_DAMAGE, scalar)
    call hash_values(hash, count, scalar)
    call simulation%health(health)
    print '(a, 1x, z10.10, 1x, i0)', formulation, hash, health%broken_bonds
    call simulation%destroy()
    call model%destroy()
    call points%destroy()
  end subroutine run

  subroutine hash_values(hash, length, values)
    integer(int64), intent(inout) :: hash
    integer, intent(in) :: length
    real(real64), intent(in) :: values(length)
    integer(int64), parameter :: factor = 65599, modulus = 1099511627689_int64
    integer(int64), parameter :: lower_half = int(z'ffffffff', int64)
    integer(int64) :: bits
    integer :: k

    do k = 1, length
      bits = transfer(values(k), bits)
      hash = mod(hash * factor + iand(bits, lower_half), modulus)
      hash = mod(hash * factor + shiftr(bits, 32), modulus)
    end do
  end subroutine hash_values

end program twins
