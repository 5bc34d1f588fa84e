! Numbers of triangles told before meshing, a function on a grid, and the outline of a figure.
program sampled
    use, intrinsic :: iso_c_binding, only: c_double, c_int32_t
    use rvachev
    implicit none
    type(rv_part) :: ball, figure
    type(rv_options) :: sizes, how
    type(rv_samples) :: samples
    type(rv_mesh) :: mesh
    type(rv_failure) :: failure
    character(1000) :: path
    real(c_double), pointer :: values(:, :, :), gradients(:, :, :, :), points(:, :)
    integer(c_int32_t), allocatable :: line(:), borders(:)
    real(c_double) :: area, left
    integer :: k, next
    call get_command_argument(1, path)
    call ball%parse('part(sphere(1))')
    call sizes%set('size', '0.1')
    call ball%mesh(mesh, sizes)
    print '(3(a, i0))', 'ball about ', ball%expected_triangles(sizes), ' made ', size(mesh%triangles(), 2), ' step ', &
        rv_expected_of_file(path)
    print '(a, i0)', 'none ', mesh%contour_count()
    call how%set('step', '0.25'); call how%set('margin', '0.5'); call how%set('gradient', 'true')
    call ball%sample(samples, how)
    values => samples%values()
    gradients => samples%gradients()
    ! The point (0.5, 0, 0): the gradient points to the middle.
    print '(2(a, i0), a, f0.9, a, i0, a, l1)', 'grid counts ', size(values, 1), ' gradients ', size(gradients) / 3, ' from ', &
        samples%origin(3), ' inside ', count(values > 0), ' inwards ', gradients(1, 9, 7, 7) < -0.4 &
        .and. maxval(abs(gradients(2:3, 9, 7, 7))) < 1e-12
    call samples%free()
    call how%set('cells', '0', failure)
    print '(a, i0)', 'refused ', failure%status
    call mesh%free()
    call figure%parse("part(region(rectangle(size=(4, 2)).name('plate')))")
    call figure%mesh(mesh)
    points => mesh%points()
    allocate (line, source=mesh%contour(1))
    allocate (borders, source=mesh%contour_borders(1))
    area = 0
    left = 0
    do k = 1, size(line)
        next = merge(1, k + 1, k == size(line))
        associate (a => points(:, line(k)), b => points(:, line(next)))
            area = area + (a(1) * b(2) - a(2) * b(1)) / 2
            if (mesh%border_name(borders(k)) == 'plate.xmin') left = left + norm2(b - a)
        end associate
    end do
    print '(2(a, i0), 2(a, f0.9))', 'contours ', mesh%contour_count(), ' borders ', mesh%border_count(), &
        ' area ', area, ' left ', left
    call mesh%free(); call ball%free(); call figure%free(); call sizes%free(); call how%free()
end program
