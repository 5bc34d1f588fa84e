! A function of Fortran as the solid, joined with a primitive: arrays of the mesh, the area of a group, and a status that comes back.

module balls
    use, intrinsic :: iso_c_binding, only: c_double
    use rvachev
    implicit none

    ! A ball; where it is told to, it stops the run.
    type, extends(rv_shape) :: ball
        real(c_double) :: radius = 1
        integer :: stop_with = 0
    contains
        procedure :: values => ball_values
        procedure :: gradients => ball_gradients
    end type

contains

    subroutine ball_values(self, xyz, value, status)
        class(ball), intent(inout) :: self
        real(c_double), intent(in) :: xyz(:, :)
        real(c_double), intent(out) :: value(:)
        integer, intent(inout) :: status
        value = self%radius - norm2(xyz, 1)
        status = self%stop_with
    end subroutine

    subroutine ball_gradients(self, xyz, gradient, status)
        class(ball), intent(inout) :: self
        real(c_double), intent(in) :: xyz(:, :)
        real(c_double), intent(out) :: gradient(:, :)
        integer, intent(inout) :: status
        gradient = -xyz / spread(max(norm2(xyz, 1), tiny(1d0)), 1, 3)
        status = self%stop_with
    end subroutine
end module

program field
    use, intrinsic :: iso_c_binding, only: c_double, c_int32_t
    use rvachev
    use balls
    implicit none
    real(c_double), parameter :: bounds(3, 2) = reshape([-1.2d0, -1.2d0, -1.2d0, 1.2d0, 1.2d0, 1.2d0], [3, 2])
    type(rv_solid) :: whole, plain, bore, rest, half
    type(rv_part) :: part
    type(rv_options) :: options
    type(rv_mesh) :: mesh, again
    type(rv_failure) :: failure
    real(c_double), pointer :: p(:, :)
    integer(c_int32_t), allocatable :: t(:, :), flat(:), nodes(:)
    real(c_double) :: at(3, 2), v(2), g(3, 2)
    character(:), allocatable :: report

    call whole%field(ball(radius=1d0), lipschitz=1d0, bounds=bounds, has_gradient=.true., concurrent=.true.)
    call plain%cylinder(0.4d0, from=[0d0, 0d0, -2d0], to=[0d0, 0d0, 2d0])
    call bore%apply(plain, 'name("bore")')
    call half%half_space([0d0, 0d0, -1d0])
    call plain%difference(whole, bore)
    call rest%apply(half, 'name("cut")')
    call half%intersection([plain, rest])
    call part%of([half])
    call part%group('flat', 'cut')
    call options%set('size', '0.12')
    call part%mesh(mesh, options, failure)
    if (failure%status /= rv_good) error stop 'no good mesh'

    p => mesh%points()
    t = mesh%triangles()
    flat = mesh%triangles_of('flat')
    nodes = mesh%nodes_of('flat')
    write (*, '(a, f0.6, a, f0.6, a, l1, a, i0)') 'half volume ', volume(p, t), ' flat ', area(p, t(:, flat)), ' sound ', &
        mesh%is_sound(), ' faces ', mesh%face_count()
    write (*, '(a, es9.2, a, i0, a, i0)') 'nodes off ', maxval(abs(p(3, nodes))), &
        ' lowest ', minval(t), ' highest ', maxval(t) - size(p, 2)
    write (*, '(a, i0, a, i0)') 'labels ', size(mesh%labels()) - size(t, 2), ' edges ', size(mesh%feature_edges(), 2)

    call part%of([whole])
    call part%rsystem('minmax')
    at = reshape([0d0, 0d0, 0.5d0, 0.9d0, 0d0, 0d0], [3, 2])
    call part%values(at, v)
    call part%gradients(at, g)
    write (*, '(a, f0.6, a, f0.6, a, f0.6)') 'values first ', v(1), ' second ', v(2), ' slope ', g(1, 2)

    call options%set('size', '0.25')
    call rv_mesh_of_triangles(again, p, t, options)
    call rv_checked(report, again%points(), again%triangles())
    write (*, '(a, i0, a, l1)') 'again checked ', index(report, '"closed":true'), ' sound ', again%is_sound()

    call whole%field(ball(radius=1d0, stop_with=42), bounds=bounds)
    call part%of([whole])
    call part%mesh(again, failure=failure)
    write (*, '(a, i0, a, i0)') 'stopped status ', failure%status, ' code ', failure%user_code
    call options%set('size', 'wrong', failure)
    write (*, '(a, i0, 2a)') 'bad status ', failure%status, ' ', failure%message

    call again%free()
    call mesh%free()
    call options%free()
    call part%free()
    call whole%free()
    call plain%free()
    call bore%free()
    call rest%free()
    call half%free()

contains

    pure function cross(a, b) result(c)
        real(c_double), intent(in) :: a(3), b(3)
        real(c_double) :: c(3)
        c = cshift(a, 1) * cshift(b, -1) - cshift(a, -1) * cshift(b, 1)
    end function

    pure function volume(p, t) result(v)
        real(c_double), intent(in) :: p(:, :)
        integer(c_int32_t), intent(in) :: t(:, :)
        real(c_double) :: v
        integer :: i
        v = 0
        do i = 1, size(t, 2)
            v = v + dot_product(p(:, t(1, i)), cross(p(:, t(2, i)), p(:, t(3, i)))) / 6
        end do
    end function

    pure function area(p, t) result(a)
        real(c_double), intent(in) :: p(:, :)
        integer(c_int32_t), intent(in) :: t(:, :)
        real(c_double) :: a
        integer :: i
        a = 0
        do i = 1, size(t, 2)
            a = a + norm2(cross(p(:, t(2, i)) - p(:, t(1, i)), p(:, t(3, i)) - p(:, t(1, i)))) / 2
        end do
    end function
end program
