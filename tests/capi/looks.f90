! Pictures, curvatures, distances, what triangles are made of, and comparisons. Arguments as for looks.c.
program looks
    use, intrinsic :: iso_c_binding, only: c_double, c_int32_t, c_int8_t
    use rvachev
    implicit none
    type(rv_part) :: part, bored, block
    type(rv_options) :: sizes, soups, samples, how
    type(rv_mesh) :: ball, cube
    type(rv_picture) :: picture, half, far
    character(1000) :: file, bores, png
    character(:), allocatable :: text
    real(c_double), pointer :: points(:, :), bends(:, :), defects(:)
    integer(c_int32_t), allocatable :: triangles(:, :)
    integer, allocatable :: classes(:)
    call get_command_argument(1, file)
    call get_command_argument(2, bores)
    call get_command_argument(3, png)
    call sizes%set('size', '0.3')
    call part%parse("part(sphere(2).name('ball'))")
    call part%mesh(ball, sizes)
    call how%set('pixels', '120x100')
    call how%set('transparent', 'true')
    call how%set('legend', 'false')
    call how%set('edges', 'none')
    call how%set('focus', '0,0,0,4')
    call how%set('view', 'front')
    call ball%draw(picture, how)
    call picture%write(png)
    print '(2(a, i0), a, f0.3)', 'picture width ', picture%width, ' height ', picture%height, ' covered ', covered(picture)
    call how%set('clip', 'x=0,above')
    call ball%draw(half, how)
    print '(a, f0.3)', 'half covered ', covered(half)
    call how%set('color', 'distance')
    call ball%draw(far, how, part)
    print '(a, f0.3)', 'far covered ', covered(far)
    points => ball%points()
    bends => ball%curvatures()
    defects => ball%angle_defects()
    print '(2(a, i0), a, f9.6, a, i0, a, f6.3, a, f14.9, a, es10.3)', 'bends nodes ', size(bends, 2), ' of ', size(points, 2), &
        ' mean ', sum(bends)/size(bends), ' order ', merge(1, 0, all(bends(1, :) >= bends(2, :))), ' most ', maxval(bends), &
        ' sum ', sum(defects), ' far ', maxval(ball%distances(part))
    call block%parse('part(box(size=(2, 2, 2)))')
    call block%mesh(cube, sizes)
    allocate (classes, source=cube%node_classes())
    print '(3(a, i0))', 'classes corners ', count(classes == 2), ' creases ', count(classes == 1), ' regular ', count(classes == 0)
    call rv_read_triangles(cube, file)
    points => cube%points()
    allocate (triangles, source=cube%triangles())
    call rv_triangles_told(text, points, triangles)
    print '(2a)', 'info 0 ', text
    call rv_triangles_told_of_file(text, file)
    print '(2a)', 'info_file 0 ', text
    call soups%set('size', '0.5')
    call rv_triangles_compared(text, points, triangles, soups)
    print '(2a)', 'soup 0 ', text
    call rv_triangles_compared_of_file(text, file, soups)
    print '(2a)', 'soup_file 0 ', text
    call samples%set('size', '0.4')
    call rv_samples_compared(text, samples)
    print '(2a)', 'samples 0 ', text
    call bored%load(bores)
    print '(2a)', 'rsystems 0 ', bored%compare_rsystems(sizes)
    call picture%free(); call half%free(); call far%free(); call ball%free(); call cube%free(); call part%free()
    call bored%free(); call block%free(); call sizes%free(); call soups%free(); call samples%free(); call how%free()
contains
    ! How many pixels are covered.
    function covered(of) result(pixels)
        type(rv_picture), intent(in) :: of
        real(c_double) :: pixels
        integer(c_int8_t), pointer :: rgba(:, :, :)
        rgba => of%pixels()
        pixels = sum(iand(int(rgba(4, :, :)), 255))/255.0_c_double
    end function
end program
