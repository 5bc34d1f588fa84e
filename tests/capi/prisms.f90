! Units, one face made anew, and prisms, of a block of 2 by 2 by 1.
program prisms_of_a_block
    use, intrinsic :: iso_c_binding, only: c_double
    use rvachev
    implicit none
    type(rv_part) :: part
    type(rv_options) :: options, finer
    type(rv_mesh) :: mesh, fine, both
    type(rv_prisms) :: prisms, paired
    type(rv_failure) :: failure
    real(c_double), pointer :: points(:, :)
    real(c_double), allocatable :: carried(:), way(:, :)
    real(c_double) :: length
    call part%parse("part(box(lo=(0, 0, 0), hi=(2, 2, 1)).name('b'))")
    call part%units('in')
    call options%set('size', '0.4')
    call finer%set('size', '0.1')
    call part%mesh(mesh, options)
    call mesh%remesh_face(fine, 'b.zmax', finer)
    call mesh%sweep(prisms, 'b.zmin', 2, along=[0.0_c_double, 0.0_c_double, -2.0_c_double])
    points => prisms%points()
    print '(4a, 2(a, i0))', 'units ', part%said_units(), ' ', mesh%units(), ' before ', size(mesh%triangles_of('b.zmax')), &
        ' after ', size(fine%triangles_of('b.zmax'))
    print '(3(a, i0), a, f0.9, a, f0.9)', 'cells ', size(prisms%cells(), 2), ' least ', minval(prisms%cells()), ' above ', &
        maxval(prisms%cells()) - size(points, 2), ' volume ', prisms%volume(), ' lowest ', minval(points(3, :))
    print '(3a, i0, a, i0)', 'first ', prisms%name(1), ' names ', prisms%name_count(), ' sides ', &
        size(prisms%sides(), 2) - size(prisms%labels())
    call prisms%pair(paired)
    print '(3(a, i0), a, f0.9, a, i0)', 'paired hexahedra ', size(paired%hexahedra(), 2), ' prisms ', size(paired%cells(), 2), &
        ' of ', size(prisms%cells(), 2), ' volume ', paired%volume(), ' least ', minval(paired%hexahedra())
    points => mesh%points()
    call mesh%carry(points(3, :) + 0.0_c_double, reshape([0.0_c_double, 1.0_c_double, 0.25_c_double], [3, 1]), carried)
    call mesh%path([1.5_c_double, 0.5_c_double, 1.0_c_double], [2.0_c_double, 1.5_c_double, 0.5_c_double], way, length)
    print '(3(a, f0.9))', 'carried ', carried(1), ' length ', length, ' from ', way(1, 1)
    call mesh%carry([1.0_c_double], points, carried, failure)
    print '(a, i0)', 'few ', failure%status
    call both%join([mesh, fine])
    print '(a, i0)', 'joined ', (size(both%triangles(), 2) - size(fine%triangles(), 2)) * 2 / size(mesh%triangles(), 2)
    call both%free(); call paired%free(); call prisms%free()
    call mesh%sweep(prisms, 'b.zmin', 2, to='b.xmax', failure=failure)
    print '(a, i0)', 'refused ', failure%status
    call prisms%free(); call fine%free(); call mesh%free(); call options%free(); call finer%free(); call part%free()
end program
