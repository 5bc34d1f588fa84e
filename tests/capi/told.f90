! Faces that decide at points, pictures of comparisons, and what is told of parts built from edges. Arguments as for told.c.
program told
    use, intrinsic :: iso_c_binding, only: c_double, c_int32_t
    use rvachev
    implicit none
    type(rv_part) :: part, bar
    type(rv_options) :: drawn, samples, soups
    type(rv_failure) :: failure
    character(1000) :: file(4)
    character(:), allocatable :: text
    integer(c_int32_t) :: faces(5)
    integer :: i
    real(c_double), parameter :: at(3, 5) = reshape([-0.95_c_double, 0.6_c_double, 0.5_c_double, 0.1_c_double, 0.97_c_double, &
        0.2_c_double, 0.1_c_double, 0.0_c_double, 0.0_c_double, 0.7_c_double, 0.6_c_double, 1.5_c_double, 0.8_c_double, &
        0.7_c_double, -1.0_c_double], [3, 5])
    do i = 1, 4
        call get_command_argument(i, file(i))
    end do
    call part%parse("part(box(size=(2, 2, 2)).name('body') - cylinder(0.4, axis='x').name('bore'))")
    call part%faces(at, faces)
    print '(a, i0)', 'faces ', part%face_count()
    print '(9a)', 'at ', part%face_name(faces(1)), (' at ', part%face_name(faces(i)), i = 2, 4), &
        ' at '//part%face_name(faces(5))
    call drawn%set('size', '0.4')
    call drawn%set('png', file(2))
    text = part%compare(drawn)
    call samples%set('size', '0.4')
    call samples%set('png', file(4))
    call rv_samples_compared(text, samples)
    call soups%set('size', '0.4')
    call soups%set('png', file(3))
    call soups%set('color', 'class')
    call rv_triangles_compared_of_file(text, file(1), soups)
    call bar%parse("units('mm')"//new_line('a')// &
        "part(extrude_edges([polyline([(0, 0), (2, 0), (2, 2), (0, 2)], closed=True)], 'z', 2).name('bar'))")
    print '(2a)', 'bar 0 ', bar%info()
    ! Of what is built from edges the nearest face decides.
    call bar%faces(at, faces, failure)
    if (failure%status /= rv_good .or. any(faces < 1)) stop 1
    call part%free(); call bar%free(); call drawn%free(); call samples%free(); call soups%free()
end program
