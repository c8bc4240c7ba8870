!> A material of the host's own: a viscoelastic bar is stretched and held, and its force relaxes.
!>
!> The law is a standard linear solid. Beside Saint Venant and Kirchhoff's stress S(E) a second one, Q,
!> grows with it and fades: dQ/dt = g dS/dt - Q/tau. Q is what the material remembers: 6 numbers at each
!> point. All of its stress fades alike, so that equilibrium stays where it is while the bar is held, and
!> the force follows exp(-t/tau) whatever the shape of the body.
!>
!> Usage: own_material [points along the bar, 20] [output file, own_material_fortran.csv]
!>
!> A law is told deformations, not the time between them: the host, which chooses the time step, tells it
!> that. While it only looks, no time passes. Units are mm, ms and g, and so MPa, N and mJ. The same
!> program stands beside this one in C and in Rust; all three print the same hash.
module own_material_host
  use, intrinsic :: iso_fortran_env, only: int64, real64
  use perion
  implicit none
  private
  public :: hash_values, solid, state_size, write_curve

  integer, parameter :: state_size = 6
  !> Where a symmetric tensor has its components: 11, 22, 33, 23, 13, 12.
  integer, parameter :: row(state_size) = [1, 2, 3, 2, 1, 1], column(state_size) = [1, 2, 3, 3, 3, 2]

  !> The law: stiffness when all has faded, how much more there is at first, and how long it takes.
  type, extends(perion_material) :: solid
    real(real64) :: lambda = 0, mu = 0       ! MPa
    real(real64) :: share = 0                ! g
    real(real64) :: relaxation_time = 1      ! tau, ms
    real(real64) :: time_step = 0            ! ms, from the last completed step to the one asked about; 0: none
  contains
    procedure :: answer => answer_solid
  end type solid

contains

  !> Answers deformation gradients: by the trapezoidal rule over a step.
  subroutine answer_solid(self, F0, F1, state0, state1, P, W, stop)
    class(solid), intent(inout) :: self
    real(real64), intent(in) :: F0(:, :, :), F1(:, :, :)
    real(real64), intent(in) :: state0(:, :)
    real(real64), intent(inout) :: state1(:, :)
    real(real64), intent(inout) :: P(:, :, :)
    real(real64), intent(inout) :: W(:)
    logical, intent(inout) :: stop
    real(real64) :: before(state_size), stress(state_size), whole(3, 3), half, energy, total
    integer :: place, c, i, j, k

    half = 0.5d0 * self%time_step / self%relaxation_time
    do place = 1, size(W)
      call elastic(self, F0(:, :, place), energy, before)
      call elastic(self, F1(:, :, place), energy, stress)
      do c = 1, state_size
        state1(c, place) = ((1 - half) * state0(c, place) + self%share * (stress(c) - before(c))) &
            / (1 + half)
        whole(row(c), column(c)) = stress(c) + state1(c, place)
        whole(column(c), row(c)) = whole(row(c), column(c))
      end do
      W(place) = energy + fading_energy(self, state1(:, place))
      do i = 1, 3
        do j = 1, 3
          total = 0
          do k = 1, 3
            total = total + F1(i, k, place) * whole(k, j)
          end do
          P(i, j, place) = total
        end do
      end do
    end do
    ! There is no reason to stop.
    stop = .false.
  end subroutine answer_solid

  !> Energy and second Piola-Kirchhoff stress of Saint Venant and Kirchhoff.
  pure subroutine elastic(own, F, energy, stress)
    class(solid), intent(in) :: own
    real(real64), intent(in) :: F(3, 3)
    real(real64), intent(out) :: energy, stress(state_size)
    real(real64) :: strain(state_size), squares, product, trace
    integer :: c, k

    squares = 0
    do c = 1, state_size
      product = 0
      do k = 1, 3
        product = product + F(k, row(c)) * F(k, column(c))
      end do
      strain(c) = 0.5d0 * (product - merge(1, 0, c <= 3))
      squares = squares + merge(1, 2, c <= 3) * strain(c) * strain(c)
    end do
    trace = strain(1) + strain(2) + strain(3)
    do c = 1, state_size
      stress(c) = 2 * own%mu * strain(c) + merge(own%lambda * trace, 0d0, c <= 3)
    end do
    energy = 0.5d0 * own%lambda * trace * trace + own%mu * squares
  end subroutine elastic

  !> The energy in the springs of Q: half of Q on the strain that C makes of it, over g.
  pure function fading_energy(own, Q) result(energy)
    class(solid), intent(in) :: own
    real(real64), intent(in) :: Q(state_size)
    real(real64) :: energy, squares, trace
    integer :: c

    trace = Q(1) + Q(2) + Q(3)
    squares = 0
    do c = 1, state_size
      squares = squares + merge(1, 2, c <= 3) * Q(c) * Q(c)
    end do
    energy = (squares - own%lambda / (3 * own%lambda + 2 * own%mu) * trace * trace) &
        / (4 * own%mu * own%share)
  end function fading_energy

  !> Time, force and closed form of each record.
  subroutine write_curve(path, forces, expected, interval)
    character(*), intent(in) :: path
    real(real64), intent(in) :: forces(0:), expected(0:), interval
    integer :: unit, record

    open (newunit=unit, file=path, status='replace', action='write')
    write (unit, '(a)') 'time (ms),force (N),closed form (N)'
    do record = 0, ubound(forces, 1)
      write (unit, '(f8.4, 2(",", f9.4))') interval * record, forces(record), expected(record)
    end do
    close (unit)
  end subroutine write_curve

  !> Goes on with a fingerprint of the bits of numbers.
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

end module own_material_host

program own_material
  use, intrinsic :: iso_fortran_env, only: error_unit, int64, real64
  use perion
  use own_material_host
  implicit none

  integer, parameter :: records = 240
  real(real64), parameter :: density = 1.2d-3, modulus = 1000, ratio = 0.3d0  ! g/mm3, MPa
  real(real64), parameter :: share = 1, relaxation_time = 0.5d0              ! ms
  real(real64), parameter :: ramp = 0.5d0, end_time = 2                      ! ms
  real(real64), parameter :: across = 4, grip = 2, strain = 0.01d0           ! mm, mm

  type(perion_points) :: points
  type(perion_model) :: model
  type(perion_simulation) :: bar
  type(perion_energy) :: energy
  type(solid), target :: own
  character(500) :: first_argument, curve
  integer :: along, count, flaw, held, record, steps
  integer(int64) :: hash
  real(real64) :: length, pull, stable, interval, reaction(3), x, left_over, faded, bearing, worst, since
  real(real64) :: forces(0:records), expected(0:records)
  real(real64), allocatable :: vectors(:, :)

  along = 20
  curve = 'own_material_fortran.csv'
  flaw = 0
  call get_command_argument(1, first_argument)
  if (command_argument_count() > 0) read (first_argument, *, iostat=flaw) along
  if (command_argument_count() > 1) call get_command_argument(2, curve)
  if (flaw /= 0 .or. along < 10) then
    write (error_unit, '(a)') 'at least 10 points along the bar are needed'
    stop 1, quiet=.true.
  end if

  ! The points: a block with a grip at each end.
  length = along
  call points%create_block([0d0, 0d0, 0d0], [length, across, across], 1d0)
  call points%add_set_box('left', [0d0, 0d0, 0d0], [grip, across, across])
  call points%add_set_box('right', [length - grip, 0d0, 0d0], [length, across, across])
  call points%count(count)

  ! The material: a formulation that asks a law at its points, and the law. The library itself needs the
  ! constants, too.
  own%mu = modulus / (2 * (1 + ratio))
  own%lambda = 2 * own%mu * ratio / (1 - 2 * ratio)
  own%share = share
  own%relaxation_time = relaxation_time
  call model%create('correspondence')
  call model%set('density', density)
  call model%set('youngs_modulus', modulus)
  call model%set('poissons_ratio', ratio)
  call model%set('horizon', 2.1d0)
  call model%set_material_function(state_size, own)
  call bar%create(points, model)
  call points%destroy()
  call model%destroy()

  ! The right grip starts and stops smoothly: its velocity is a triangle over time.
  pull = strain * (length - 2 * grip)
  call bar%prescribe('left', PERION_QUANTITY_DISPLACEMENT, 1, 0d0)
  call bar%prescribe_table('right', PERION_QUANTITY_VELOCITY, 1, [0d0, 0.5d0 * ramp, ramp], &
      [0d0, 2 * pull / ramp, 0d0])

  ! No time has passed yet: the law is at its stiffest. From then on it knows the step.
  call bar%stable_time_step(stable)
  interval = end_time / records
  steps = ceiling(interval / (0.9d0 * stable))
  print '(i0, a, i0, a, f6.4, a)', count, ' points, ', records * steps, ' steps of ', &
      1d3 * interval / steps, ' us'
  own%time_step = interval / steps
  forces(0) = 0
  do record = 1, records
    call bar%step(interval / steps, steps)
    call bar%sum(PERION_FIELD_REACTION, reaction, 'right')
    forces(record) = reaction(1)
  end do
  own%time_step = 0

  ! Results: while the bar is held, its force is that of the elastic bar times 1 + g c exp(-t/tau), where
  ! c is what the pull has left of Q. The last record says what the elastic bar bears.
  x = 0.5d0 * ramp / relaxation_time
  left_over = share * ((1 - exp(-x)) / x)**2
  faded = 1 + left_over * exp((ramp - end_time) / relaxation_time)
  bearing = forces(records) / faded
  held = int(ramp / interval + 0.5d0)
  expected = forces
  worst = 0
  do record = held, records
    since = interval * record - ramp
    expected(record) = bearing * (1 + left_over * exp(-since / relaxation_time))
    worst = max(worst, abs(forces(record) - expected(record)) / bearing)
  end do
  call bar%energy(energy)
  print '(a, f10.4, a)', 'force at first  ', forces(held), ' N'
  print '(a, f10.4, a)', 'force at last   ', forces(records), ' N'
  print '(a, f10.4, a)', 'E A strain      ', modulus * across * across * strain, ' N'
  print '(a, f10.4, a)', 'off exp(-t/tau) ', 100 * worst, ' %'
  print '(a, f10.4, a)', 'work            ', energy%external_work, ' mJ'
  print '(a, f10.4, a)', 'stored          ', energy%elastic, ' mJ'
  ! What the dashpots took is not known to the library: to it that is energy that went missing.
  print '(a, f10.4, a)', 'in the dashpots ', -energy%closure_error, ' mJ'
  allocate (vectors(3, count))
  hash = 0
  call bar%get(PERION_FIELD_DISPLACEMENT, vectors)
  call hash_values(hash, size(vectors), vectors)
  call bar%get(PERION_FIELD_VELOCITY, vectors)
  call hash_values(hash, size(vectors), vectors)
  print '(a, z10.10)', 'hash            ', hash
  if (curve /= '') call write_curve(curve, forces, expected, interval)

  call bar%destroy()
end program own_material
