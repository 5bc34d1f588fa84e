! rvachev.f90: the library for C from Fortran 2018.
!
! Module rvachev has types with bound procedures; module rvachev_c below it has the calls of rvachev.h as they are.
!
! Handles are freed by their free(), once; an assignment copies the handle, not what it stands for. Numbers of nodes, triangles and
! faces are from 1 unless `first` says otherwise. Each call takes an optional `failure`; without it what goes wrong ends the program.
! Names and texts need no zero at their end.

module rvachev_c
    use, intrinsic :: iso_c_binding, only: c_char, c_double, c_funptr, c_int, c_int32_t, c_ptr, c_size_t, c_null_funptr, c_null_ptr
    implicit none
    public

    integer, parameter :: rv_good = 0, rv_short = 1, rv_usage = 2, rv_input = 3, rv_failed = 4, rv_stopped = 5, rv_cancelled = 130

    ! rv_field of rvachev.h.
    type, bind(c) :: c_field
        type(c_funptr) :: function = c_null_funptr
        type(c_ptr) :: user = c_null_ptr
        type(c_funptr) :: release = c_null_funptr
        real(c_double) :: lipschitz = 0
        type(c_ptr) :: bounds = c_null_ptr
        integer(c_int) :: has_gradient = 0
        integer(c_int) :: concurrent = 0
    end type

    ! rv_sweep of rvachev.h.
    type, bind(c) :: c_sweep
        type(c_ptr) :: face = c_null_ptr
        type(c_ptr) :: to = c_null_ptr
        type(c_ptr) :: along = c_null_ptr
        integer(c_size_t) :: layers = 0
    end type

    ! rv_carry of rvachev.h.
    type, bind(c) :: c_carry
        type(c_ptr) :: values = c_null_ptr
        integer(c_size_t) :: width = 0
        type(c_ptr) :: xyz = c_null_ptr
        integer(c_size_t) :: count = 0
        type(c_ptr) :: carried = c_null_ptr
        type(c_ptr) :: distances = c_null_ptr
    end type

    ! rv_share of rvachev.h.
    type, bind(c) :: c_share
        integer(c_int32_t) :: number = 1
        integer(c_int32_t) :: of = 1
        integer(c_int32_t) :: round = 0
    end type

    ! rv_surface of rvachev.h; points of triangles are from 0 there.
    type, bind(c) :: c_surface
        type(c_ptr) :: points = c_null_ptr
        integer(c_size_t) :: point_count = 0
        type(c_ptr) :: triangles = c_null_ptr
        integer(c_size_t) :: triangle_count = 0
    end type

    interface
        function rv_version() bind(c) result(status)
            import :: c_ptr
            type(c_ptr) :: status
        end function
        function rv_error_status(error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: error
            integer(c_int) :: status
        end function
        function rv_error_message(error) bind(c) result(status)
            import :: c_ptr
            type(c_ptr), value :: error
            type(c_ptr) :: status
        end function
        function rv_error_help(error) bind(c) result(status)
            import :: c_ptr
            type(c_ptr), value :: error
            type(c_ptr) :: status
        end function
        function rv_error_file(error) bind(c) result(status)
            import :: c_ptr
            type(c_ptr), value :: error
            type(c_ptr) :: status
        end function
        function rv_error_line(error) bind(c) result(status)
            import :: c_ptr, c_size_t
            type(c_ptr), value :: error
            integer(c_size_t) :: status
        end function
        function rv_error_column(error) bind(c) result(status)
            import :: c_ptr, c_size_t
            type(c_ptr), value :: error
            integer(c_size_t) :: status
        end function
        function rv_error_user_code(error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: error
            integer(c_int) :: status
        end function
        function rv_error_user(error) bind(c) result(status)
            import :: c_ptr
            type(c_ptr), value :: error
            type(c_ptr) :: status
        end function
        subroutine rv_error_free(error) bind(c)
            import :: c_ptr
            type(c_ptr), value :: error
        end subroutine
        function rv_options_new(options, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), intent(out) :: options
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_options_set(options, name, value, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: options
            character(kind=c_char), intent(in) :: name(*)
            character(kind=c_char), intent(in) :: value(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_options_set_run(options, run, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: options
            type(c_ptr), value :: run
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_options_free(options) bind(c)
            import :: c_ptr
            type(c_ptr), value :: options
        end subroutine
        function rv_run_new(run, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), intent(out) :: run
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_run_cancel(run, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: run
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_run_progress(run, stage, capacity, done, error) bind(c) result(status)
            import :: c_char, c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: run
            character(kind=c_char), intent(out) :: stage(*)
            integer(c_size_t), value :: capacity
            real(c_double), intent(out) :: done
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_run_free(run) bind(c)
            import :: c_ptr
            type(c_ptr), value :: run
        end subroutine
        function rv_solid_parse(text, solid, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: text(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_box(lo, hi, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            real(c_double), intent(in) :: lo(*)
            real(c_double), intent(in) :: hi(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_sphere(radius, at, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            real(c_double), value :: radius
            real(c_double), intent(in), optional :: at(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_cylinder(radius, from, to, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            real(c_double), value :: radius
            real(c_double), intent(in) :: from(*)
            real(c_double), intent(in) :: to(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_cone(radii, from, to, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            real(c_double), intent(in) :: radii(*)
            real(c_double), intent(in) :: from(*)
            real(c_double), intent(in) :: to(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_torus(radii, axis, at, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            real(c_double), intent(in) :: radii(*)
            real(c_double), intent(in), optional :: axis(*)
            real(c_double), intent(in), optional :: at(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_half_space(normal, at, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            real(c_double), intent(in) :: normal(*)
            real(c_double), intent(in), optional :: at(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_union(solids, count, solid, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), intent(in) :: solids(*)
            integer(c_size_t), value :: count
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_intersection(solids, count, solid, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), intent(in) :: solids(*)
            integer(c_size_t), value :: count
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_difference(a, b, solid, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: a
            type(c_ptr), value :: b
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_complement(a, solid, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: a
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_blend(a, b, radius, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: a
            type(c_ptr), value :: b
            real(c_double), value :: radius
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_move(a, by, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: a
            real(c_double), intent(in) :: by(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_rotate(a, degrees, axis, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: a
            real(c_double), value :: degrees
            real(c_double), intent(in) :: axis(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_scale(a, factor, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: a
            real(c_double), value :: factor
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_name(a, name, solid, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: a
            character(kind=c_char), intent(in) :: name(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_size(a, length, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: a
            real(c_double), value :: length
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_apply(a, methods, solid, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: a
            character(kind=c_char), intent(in) :: methods(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_solid_free(solid) bind(c)
            import :: c_ptr
            type(c_ptr), value :: solid
        end subroutine
        function rv_solid_field(field, solid, error) bind(c) result(status)
            import :: c_field, c_int, c_ptr
            type(c_field), intent(in) :: field
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_solid_grid(counts, bounds, values, solid, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            integer(c_size_t), intent(in) :: counts(*)
            real(c_double), intent(in), optional :: bounds(*)
            real(c_double), intent(in) :: values(*)
            type(c_ptr), intent(out) :: solid
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_parse(source, options, part, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: source(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: part
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_load(path, options, part, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: part
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_new(solids, count, part, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), intent(in) :: solids(*)
            integer(c_size_t), value :: count
            type(c_ptr), intent(out) :: part
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_set_units(part, units, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: part
            character(kind=c_char), intent(in) :: units(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_set_rsystem(part, rsystem, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: part
            character(kind=c_char), intent(in) :: rsystem(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_set_domain(part, bounds, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: part
            real(c_double), intent(in), optional :: bounds(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_group(part, name, faces, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: part
            character(kind=c_char), intent(in) :: name(*)
            character(kind=c_char), intent(in) :: faces(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_info(part, info, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            type(c_ptr), intent(out) :: info
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_values(part, count, xyz, values, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_size_t), value :: count
            real(c_double), intent(in) :: xyz(*)
            real(c_double), intent(out) :: values(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_gradients(part, count, xyz, gradients, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_size_t), value :: count
            real(c_double), intent(in) :: xyz(*)
            real(c_double), intent(out) :: gradients(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_faces(part, count, xyz, faces, error) bind(c) result(status)
            import :: c_double, c_int, c_int32_t, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_size_t), value :: count
            real(c_double), intent(in) :: xyz(*)
            integer(c_int32_t), intent(out) :: faces(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_face_count(part, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_face_name(part, index, name, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: part
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: name
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_mesh(part, options, mesh, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: mesh
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_write_step(part, path, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: part
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_write(part, path, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: part
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_part_free(part) bind(c)
            import :: c_ptr
            type(c_ptr), value :: part
        end subroutine
        function rv_mesh_file(path, options, mesh, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: mesh
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_read(path, options, mesh, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: mesh
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_remesh(surface, options, mesh, error) bind(c) result(status)
            import :: c_int, c_ptr, c_surface
            type(c_surface), intent(in) :: surface
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: mesh
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_heal(surface, options, mesh, error) bind(c) result(status)
            import :: c_int, c_ptr, c_surface
            type(c_surface), intent(in) :: surface
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: mesh
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_check(surface, part, options, report, error) bind(c) result(status)
            import :: c_int, c_ptr, c_surface
            type(c_surface), intent(in) :: surface
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_check_file(surface, path, options, report, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr, c_surface
            type(c_surface), intent(in) :: surface
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_points(mesh, xyz, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: xyz
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_triangles(mesh, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_labels(mesh, faces, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: faces
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_normals(mesh, xyz, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: xyz
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_feature_edges(mesh, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_corners(mesh, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_triangles_of(mesh, name, triangles, count, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            character(kind=c_char), intent(in) :: name(*)
            type(c_ptr), intent(out) :: triangles
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_nodes_of(mesh, name, nodes, count, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            character(kind=c_char), intent(in) :: name(*)
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_face_count(mesh, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_face_name(mesh, index, name, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: name
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_group_count(mesh, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_group_name(mesh, index, name, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: name
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_shortfall_count(mesh, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_shortfall(mesh, index, text, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: text
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_warning_count(mesh, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_warning(mesh, index, text, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: text
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_report(mesh, text, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: text
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_is_sound(mesh, sound, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: mesh
            integer(c_int), intent(out) :: sound
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_write(mesh, path, options, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: mesh
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_mesh_free(mesh) bind(c)
            import :: c_ptr
            type(c_ptr), value :: mesh
        end subroutine
        function rv_part_units(part, units, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            type(c_ptr), intent(out) :: units
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_units(mesh, units, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: units
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_remesh_face(mesh, face, options, made, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: mesh
            character(kind=c_char), intent(in) :: face(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: made
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_page(mesh, title, page, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: mesh
            character(kind=c_char), intent(in) :: title(*)
            type(c_ptr), intent(out) :: page
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_sweep(mesh, sweep, prisms, error) bind(c) result(status)
            import :: c_int, c_ptr, c_sweep
            type(c_ptr), value :: mesh
            type(c_sweep), intent(in) :: sweep
            type(c_ptr), intent(out) :: prisms
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_points(prisms, xyz, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            type(c_ptr), intent(out) :: xyz
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_cells(prisms, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_pair(prisms, off, paired, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: prisms
            real(c_double), value :: off
            type(c_ptr), intent(out) :: paired
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_hexahedra(prisms, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_carry(mesh, what, error) bind(c) result(status)
            import :: c_carry, c_int, c_ptr
            type(c_ptr), value :: mesh
            type(c_carry), intent(in) :: what
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_join(meshes, count, options, joined, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), intent(in) :: meshes(*)
            integer(c_size_t), value :: count
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: joined
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_path(mesh, from, to, path, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: mesh
            real(c_double), intent(in) :: from(3)
            real(c_double), intent(in) :: to(3)
            type(c_ptr), intent(out) :: path
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_path_points(path, xyz, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: path
            type(c_ptr), intent(out) :: xyz
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_path_length(path, length, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: path
            real(c_double), intent(out) :: length
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_path_free(path) bind(c)
            import :: c_ptr
            type(c_ptr), value :: path
        end subroutine
        function rv_prisms_sides(prisms, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_labels(prisms, names, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            type(c_ptr), intent(out) :: names
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_name_count(prisms, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_name(prisms, index, name, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: prisms
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: name
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_volume(prisms, volume, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: prisms
            real(c_double), intent(out) :: volume
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_prisms_write(prisms, path, options, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: prisms
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_prisms_free(prisms) bind(c)
            import :: c_ptr
            type(c_ptr), value :: prisms
        end subroutine
        function rv_expected_triangles(part, options, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_expected_triangles_file(path, options, count, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr, c_size_t
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_part_sample(part, options, samples, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: samples
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_samples_frame(samples, counts, origin, step, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr, c_size_t
            type(c_ptr), value :: samples
            integer(c_size_t), intent(out) :: counts(*)
            real(c_double), intent(out) :: origin(*)
            real(c_double), intent(out) :: step
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_samples_values(samples, values, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: samples
            type(c_ptr), intent(out) :: values
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_samples_gradients(samples, xyz, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: samples
            type(c_ptr), intent(out) :: xyz
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_samples_write(samples, path, options, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: samples
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_samples_free(samples) bind(c)
            import :: c_ptr
            type(c_ptr), value :: samples
        end subroutine
        function rv_mesh_contour_count(mesh, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_contour(mesh, index, nodes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: nodes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_contour_borders(mesh, index, borders, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: borders
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_border_count(mesh, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_border_name(mesh, index, name, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            integer(c_size_t), value :: index
            type(c_ptr), intent(out) :: name
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_step_check(path, options, report, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_step_info(path, options, info, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: info
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_compare(part, options, report, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_compare_rsystems(part, options, report, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_compare_samples(options, report, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_triangles_info(surface, options, report, error) bind(c) result(status)
            import :: c_int, c_ptr, c_surface
            type(c_surface), intent(in) :: surface
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_triangles_info_file(path, options, report, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_compare_triangles(surface, options, report, error) bind(c) result(status)
            import :: c_int, c_ptr, c_surface
            type(c_surface), intent(in) :: surface
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_compare_triangles_file(path, options, report, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_curvatures(mesh, principal, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: principal
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_angle_defects(mesh, radians, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: radians
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_node_classes(mesh, classes, count, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: mesh
            type(c_ptr), intent(out) :: classes
            integer(c_size_t), intent(out) :: count
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_distances(mesh, part, options, distances, error) bind(c) result(status)
            import :: c_double, c_int, c_ptr
            type(c_ptr), value :: mesh
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            real(c_double), intent(out) :: distances(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_mesh_picture(mesh, part, options, picture, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: mesh
            type(c_ptr), value :: part
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: picture
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_picture_pixels(picture, rgba, width, height, error) bind(c) result(status)
            import :: c_int, c_ptr, c_size_t
            type(c_ptr), value :: picture
            type(c_ptr), intent(out) :: rgba
            integer(c_size_t), intent(out) :: width
            integer(c_size_t), intent(out) :: height
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_picture_write(picture, path, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            type(c_ptr), value :: picture
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_picture_free(picture) bind(c)
            import :: c_ptr
            type(c_ptr), value :: picture
        end subroutine
        function rv_bricks_plan(path, counts, options, folder, error) bind(c) result(status)
            import :: c_char, c_int, c_int32_t, c_ptr
            character(kind=c_char), intent(in) :: path(*)
            integer(c_int32_t), intent(in) :: counts(*)
            type(c_ptr), value :: options
            character(kind=c_char), intent(in) :: folder(*)
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_bricks_make(folder, share, options, made, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr, c_share, c_size_t
            character(kind=c_char), intent(in) :: folder(*)
            type(c_share), intent(in), optional :: share
            type(c_ptr), value :: options
            integer(c_size_t), intent(out) :: made
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_bricks_merge(folder, path, options, report, error) bind(c) result(status)
            import :: c_char, c_int, c_ptr
            character(kind=c_char), intent(in) :: folder(*)
            character(kind=c_char), intent(in) :: path(*)
            type(c_ptr), value :: options
            type(c_ptr), intent(out) :: report
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        function rv_text_chars(text, chars, error) bind(c) result(status)
            import :: c_int, c_ptr
            type(c_ptr), value :: text
            type(c_ptr), intent(out) :: chars
            type(c_ptr), intent(out) :: error
            integer(c_int) :: status
        end function
        subroutine rv_text_free(text) bind(c)
            import :: c_ptr
            type(c_ptr), value :: text
        end subroutine
    end interface
end module

module rvachev
    use, intrinsic :: iso_c_binding
    use, intrinsic :: iso_fortran_env, only: error_unit
    use rvachev_c
    implicit none
    private
    public :: rv_good, rv_short, rv_usage, rv_input, rv_failed, rv_stopped, rv_cancelled
    public :: rv_failure, rv_run, rv_options, rv_solid, rv_part, rv_mesh, rv_picture, rv_prisms, rv_samples, rv_shape
    public :: rv_mesh_of_file, rv_mesh_of_triangles, rv_healed, rv_read_triangles, rv_checked, rv_expected_of_file
    public :: rv_triangles_told, rv_triangles_told_of_file, rv_triangles_compared, rv_triangles_compared_of_file
    public :: rv_samples_compared
    public :: rv_step_checked, rv_step_told, rv_planned, rv_made, rv_merged

    ! What a call came to: a status of rvachev.h, and what is known of it (empty and 0 where nothing is).
    type :: rv_failure
        integer :: status = 0, line = 0, column = 0, user_code = 0
        character(:), allocatable :: message, help, file
    end type

    ! Cancels and watches a call, from any thread.
    type :: rv_run
        type(c_ptr) :: handle = c_null_ptr
    contains
        procedure :: make => run_make
        procedure :: cancel => run_cancel
        procedure :: progress => run_progress
        procedure :: free => run_free
    end type

    ! Options by the names of the command; made when the first one is set.
    type :: rv_options
        type(c_ptr) :: handle = c_null_ptr
    contains
        procedure :: set => options_set
        procedure :: watched_by => options_watched_by
        procedure :: free => options_free
    end type

    type :: rv_solid
        type(c_ptr) :: handle = c_null_ptr
    contains
        procedure :: parse => solid_parse
        procedure :: box => solid_box
        procedure :: sphere => solid_sphere
        procedure :: cylinder => solid_cylinder
        procedure :: cone => solid_cone
        procedure :: torus => solid_torus
        procedure :: half_space => solid_half_space
        procedure :: union => solid_union
        procedure :: intersection => solid_intersection
        procedure :: difference => solid_difference
        procedure :: complement => solid_complement
        procedure :: blend => solid_blend
        procedure :: apply => solid_apply
        procedure :: field => solid_field
        procedure :: grid => solid_grid
        procedure :: free => solid_free
    end type

    type :: rv_part
        type(c_ptr) :: handle = c_null_ptr
    contains
        procedure :: parse => part_parse
        procedure :: load => part_load
        procedure :: of => part_of
        procedure :: units => part_units
        procedure :: said_units => part_said_units
        procedure :: rsystem => part_rsystem
        procedure :: domain => part_domain
        procedure :: group => part_group
        procedure :: info => part_info
        procedure :: values => part_values
        procedure :: gradients => part_gradients
        procedure :: faces => part_faces
        procedure :: face_count => part_face_count
        procedure :: face_name => part_face_name
        procedure :: mesh => part_mesh
        procedure :: expected_triangles => part_expected_triangles
        procedure :: sample => part_sample
        procedure :: compare => part_compare
        procedure :: compare_rsystems => part_compare_rsystems
        procedure :: write => part_write
        procedure :: write_step => part_write_step
        procedure :: free => part_free
    end type

    type :: rv_mesh
        type(c_ptr) :: handle = c_null_ptr
    contains
        ! Pointers to the mesh's own memory: gone when it is freed.
        procedure :: points => mesh_points
        procedure :: normals => mesh_normals
        procedure :: curvatures => mesh_curvatures
        procedure :: angle_defects => mesh_angle_defects
        ! Copies.
        procedure :: node_classes => mesh_node_classes
        procedure :: distances => mesh_distances
        procedure :: triangles => mesh_triangles
        procedure :: labels => mesh_labels
        procedure :: feature_edges => mesh_feature_edges
        procedure :: corners => mesh_corners
        procedure :: triangles_of => mesh_triangles_of
        procedure :: nodes_of => mesh_nodes_of
        procedure :: contour => mesh_contour
        procedure :: contour_borders => mesh_contour_borders
        procedure :: contour_count => mesh_contour_count
        procedure :: border_count => mesh_border_count
        procedure :: border_name => mesh_border_name
        procedure :: face_count => mesh_face_count
        procedure :: face_name => mesh_face_name
        procedure :: group_count => mesh_group_count
        procedure :: group_name => mesh_group_name
        procedure :: shortfall_count => mesh_shortfall_count
        procedure :: shortfall => mesh_shortfall
        procedure :: warning_count => mesh_warning_count
        procedure :: warning => mesh_warning
        procedure :: report => mesh_report
        procedure :: is_sound => mesh_is_sound
        procedure :: units => mesh_units
        procedure :: remesh_face => mesh_remesh_face
        procedure :: sweep => mesh_sweep
        procedure :: carry => mesh_carry
        procedure :: path => mesh_path
        procedure :: join => mesh_join
        procedure :: page => mesh_page
        procedure :: draw => mesh_draw
        procedure :: write => mesh_write
        procedure :: free => mesh_free
    end type

    ! Pixels, and PNG files of them: draw of a mesh makes it.
    type :: rv_picture
        type(c_ptr) :: handle = c_null_ptr
        integer(c_size_t) :: width = 0, height = 0
    contains
        ! A pointer to the picture's own memory: gone when it is freed.
        procedure :: pixels => picture_pixels
        procedure :: write => picture_write
        procedure :: free => picture_free
    end type

    ! A part's function on a regular grid: point (i, j, k), from 1, is at origin + step * [i - 1, j - 1, k - 1].
    type :: rv_samples
        type(c_ptr) :: handle = c_null_ptr
        integer(c_size_t) :: counts(3) = 0
        real(c_double) :: origin(3) = 0, step = 0
    contains
        ! Pointers to the library's own memory: gone when it is freed.
        procedure :: values => samples_values
        procedure :: gradients => samples_gradients
        procedure :: write => samples_write
        procedure :: free => samples_free
    end type

    ! A volume in layers of prisms.
    type :: rv_prisms
        type(c_ptr) :: handle = c_null_ptr
    contains
        ! A pointer to the library's own memory: gone when it is freed.
        procedure :: points => prisms_points
        ! Copies.
        procedure :: cells => prisms_cells
        procedure :: hexahedra => prisms_hexahedra
        procedure :: pair => prisms_pair
        procedure :: sides => prisms_sides
        procedure :: labels => prisms_labels
        procedure :: name_count => prisms_name_count
        procedure :: name => prisms_name
        procedure :: volume => prisms_volume
        procedure :: write => prisms_write
        procedure :: free => prisms_free
    end type

    ! A function as a solid: extend this by what the function needs to know. The library keeps a copy.
    type, abstract :: rv_shape
    contains
        ! Values at points xyz(3, n), positive inside, best about the distance near the surface. A status other than 0 stops the run,
        ! and comes back as user_code of the failure.
        procedure(shape_values), deferred :: values
        ! Gradients (3, n), where they are known: see `has_gradient` of field().
        procedure :: gradients => shape_gradients
    end type

    abstract interface
        subroutine shape_values(self, xyz, value, status)
            import :: rv_shape, c_double
            class(rv_shape), intent(inout) :: self
            real(c_double), intent(in) :: xyz(:, :)
            real(c_double), intent(out) :: value(:)
            integer, intent(inout) :: status
        end subroutine
    end interface

    ! What a field's `user` pointer points to.
    type :: holder
        class(rv_shape), allocatable :: shape
    end type

contains

    ! ------------------------------------------------------------------------------------------------------------- texts, errors

    function text_of(chars) result(text)
        type(c_ptr), intent(in) :: chars
        character(:), allocatable :: text
        character(kind=c_char), pointer :: c(:)
        integer :: n, i
        interface
            function strlen(s) bind(c)
                import :: c_ptr, c_size_t
                type(c_ptr), value :: s
                integer(c_size_t) :: strlen
            end function
        end interface
        n = 0
        if (c_associated(chars)) n = int(strlen(chars))
        allocate (character(n) :: text)
        if (n == 0) return
        call c_f_pointer(chars, c, [n])
        do i = 1, n
            text(i:i) = c(i)
        end do
    end function

    ! Keeps what a call came to and frees its error; without a place for it what went wrong ends the program.
    subroutine keep(status, error, failure)
        integer(c_int), intent(in) :: status
        type(c_ptr), intent(in) :: error
        type(rv_failure), intent(out), optional :: failure
        type(rv_failure) :: f
        f%status = status
        f%message = text_of(c_null_ptr)
        f%help = f%message
        f%file = f%message
        if (c_associated(error)) then
            f%line = int(rv_error_line(error))
            f%column = int(rv_error_column(error))
            f%user_code = rv_error_user_code(error)
            f%message = text_of(rv_error_message(error))
            f%help = text_of(rv_error_help(error))
            f%file = text_of(rv_error_file(error))
            call rv_error_free(error)
        end if
        if (present(failure)) then
            failure = f
        else if (status > rv_short) then
            write (error_unit, '(a)') 'rvachev: '//f%message
            if (len(f%help) > 0) write (error_unit, '(a)') 'help: '//f%help
            error stop 4
        end if
    end subroutine

    function handle_of(options) result(handle)
        type(rv_options), intent(in), optional :: options
        type(c_ptr) :: handle
        handle = c_null_ptr
        if (present(options)) handle = options%handle
    end function

    ! ------------------------------------------------------------------------------------------------------------- runs, options

    subroutine run_make(self, failure)
        class(rv_run), intent(inout) :: self
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        call self%free()
        status = rv_run_new(self%handle, error)
        call keep(status, error, failure)
    end subroutine

    subroutine run_cancel(self, failure)
        class(rv_run), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_run_cancel(self%handle, error)
        call keep(status, error, failure)
    end subroutine

    ! The stage at the moment, and the share of it that is done.
    subroutine run_progress(self, stage, done, failure)
        class(rv_run), intent(in) :: self
        character(:), allocatable, intent(out) :: stage
        real(c_double), intent(out) :: done
        type(rv_failure), intent(out), optional :: failure
        character(kind=c_char), target :: room(80)
        type(c_ptr) :: error
        integer(c_int) :: status
        room = c_null_char
        status = rv_run_progress(self%handle, room, int(size(room), c_size_t), done, error)
        stage = text_of(c_loc(room))
        call keep(status, error, failure)
    end subroutine

    subroutine run_free(self)
        class(rv_run), intent(inout) :: self
        call rv_run_free(self%handle)
        self%handle = c_null_ptr
    end subroutine

    subroutine options_set(self, name, value, failure)
        class(rv_options), intent(inout) :: self
        character(*), intent(in) :: name, value
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        if (.not. c_associated(self%handle)) then
            status = rv_options_new(self%handle, error)
            if (status /= rv_good) call keep(status, error, failure)
            if (status /= rv_good) return
        end if
        status = rv_options_set(self%handle, trim(name)//c_null_char, trim(value)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    subroutine options_watched_by(self, run, failure)
        class(rv_options), intent(inout) :: self
        type(rv_run), intent(in) :: run
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        if (.not. c_associated(self%handle)) then
            status = rv_options_new(self%handle, error)
            if (status /= rv_good) call keep(status, error, failure)
            if (status /= rv_good) return
        end if
        status = rv_options_set_run(self%handle, run%handle, error)
        call keep(status, error, failure)
    end subroutine

    subroutine options_free(self)
        class(rv_options), intent(inout) :: self
        call rv_options_free(self%handle)
        self%handle = c_null_ptr
    end subroutine

    ! -------------------------------------------------------------------------------------------------------------------- solids

    ! As part files have it.
    subroutine solid_parse(self, text, failure)
        class(rv_solid), intent(inout) :: self
        character(*), intent(in) :: text
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_parse(trim(text)//c_null_char, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_box(self, lo, hi, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: lo(3)
        real(c_double), intent(in) :: hi(3)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_box(lo, hi, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_sphere(self, radius, at, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: radius
        real(c_double), intent(in), optional :: at(3)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_sphere(radius, at, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Between the centers of its ends.
    subroutine solid_cylinder(self, radius, from, to, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: radius
        real(c_double), intent(in) :: from(3)
        real(c_double), intent(in) :: to(3)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_cylinder(radius, from, to, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_cone(self, radii, from, to, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: radii(2)
        real(c_double), intent(in) :: from(3)
        real(c_double), intent(in) :: to(3)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_cone(radii, from, to, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! The radii of the ring and of its tube.
    subroutine solid_torus(self, radii, axis, at, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: radii(2)
        real(c_double), intent(in), optional :: axis(3)
        real(c_double), intent(in), optional :: at(3)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_torus(radii, axis, at, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! The side the normal points away from.
    subroutine solid_half_space(self, normal, at, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: normal(3)
        real(c_double), intent(in), optional :: at(3)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_half_space(normal, at, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_union(self, solids, failure)
        class(rv_solid), intent(inout) :: self
        type(rv_solid), intent(in) :: solids(:)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        type(c_ptr) :: handles(size(solids))
        integer :: i
        handles = [(solids(i)%handle, i=1, size(solids))]
        status = rv_solid_union(handles, size(solids, kind=c_size_t), made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_intersection(self, solids, failure)
        class(rv_solid), intent(inout) :: self
        type(rv_solid), intent(in) :: solids(:)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        type(c_ptr) :: handles(size(solids))
        integer :: i
        handles = [(solids(i)%handle, i=1, size(solids))]
        status = rv_solid_intersection(handles, size(solids, kind=c_size_t), made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_difference(self, a, b, failure)
        class(rv_solid), intent(inout) :: self
        class(rv_solid), intent(in) :: a
        class(rv_solid), intent(in) :: b
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_difference(a%handle, b%handle, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_complement(self, a, failure)
        class(rv_solid), intent(inout) :: self
        class(rv_solid), intent(in) :: a
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_complement(a%handle, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_blend(self, a, b, radius, failure)
        class(rv_solid), intent(inout) :: self
        class(rv_solid), intent(in) :: a
        class(rv_solid), intent(in) :: b
        real(c_double), intent(in) :: radius
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_blend(a%handle, b%handle, radius, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Methods of part files: move((1, 0, 0)), rotate(90, axis="x"), scale(2), name("arm"), size(0.1), or a chain of them.
    subroutine solid_apply(self, a, methods, failure)
        class(rv_solid), intent(inout) :: self
        class(rv_solid), intent(in) :: a
        character(*), intent(in) :: methods
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_solid_apply(a%handle, trim(methods)//c_null_char, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Where a shape's values are positive. Say how much values change per length at most (lipschitz), and where to ask (bounds: corners
    ! in columns); concurrent shapes may be asked by several threads at once.
    subroutine solid_field(self, shape, lipschitz, bounds, has_gradient, concurrent, failure)
        class(rv_solid), intent(inout) :: self
        class(rv_shape), intent(in) :: shape
        real(c_double), intent(in), optional :: lipschitz, bounds(3, 2)
        logical, intent(in), optional :: has_gradient, concurrent
        type(rv_failure), intent(out), optional :: failure
        type(c_field) :: field
        type(holder), pointer :: kept
        real(c_double), target :: box(3, 2)
        type(c_ptr) :: made, error
        integer(c_int) :: status
        allocate (kept)
        allocate (kept%shape, source=shape)
        field%function = c_funloc(asked)
        field%user = c_loc(kept)
        field%release = c_funloc(released)
        if (present(lipschitz)) field%lipschitz = lipschitz
        if (present(bounds)) then
            box = bounds
            field%bounds = c_loc(box)
        end if
        if (present(has_gradient)) field%has_gradient = merge(1, 0, has_gradient)
        if (present(concurrent)) field%concurrent = merge(1, 0, concurrent)
        status = rv_solid_field(field, made, error)
        if (status /= rv_good) deallocate (kept)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Values at points from corner to corner of bounds (in columns), trilinear between them.
    subroutine solid_grid(self, values, bounds, failure)
        class(rv_solid), intent(inout) :: self
        real(c_double), intent(in) :: values(:, :, :), bounds(3, 2)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        integer(c_size_t) :: counts(3)
        real(c_double) :: box(6)
        box = reshape(bounds, [6])
        counts = shape(values, kind=c_size_t)
        status = rv_solid_grid(counts, box, values, made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine solid_free(self)
        class(rv_solid), intent(inout) :: self
        call rv_solid_free(self%handle)
        self%handle = c_null_ptr
    end subroutine

    ! Called by the library, from its threads.
    function asked(n, xyz, value, gradient, user) result(code) bind(c)
        integer(c_size_t), value :: n
        real(c_double), intent(in) :: xyz(3, n)
        real(c_double), intent(out) :: value(n)
        type(c_ptr), value :: gradient, user
        integer(c_int) :: code
        type(holder), pointer :: kept
        real(c_double), pointer :: slopes(:, :)
        integer :: status
        call c_f_pointer(user, kept)
        status = 0
        call kept%shape%values(xyz, value, status)
        if (status == 0 .and. c_associated(gradient)) then
            call c_f_pointer(gradient, slopes, [3, int(n)])
            call kept%shape%gradients(xyz, slopes, status)
        end if
        code = status
    end function

    subroutine released(user) bind(c)
        type(c_ptr), value :: user
        type(holder), pointer :: kept
        call c_f_pointer(user, kept)
        deallocate (kept)
    end subroutine

    ! For shapes that do not say theirs: has_gradient=.true. without gradients stops the run.
    subroutine shape_gradients(self, xyz, gradient, status)
        class(rv_shape), intent(inout) :: self
        real(c_double), intent(in) :: xyz(:, :)
        real(c_double), intent(out) :: gradient(:, :)
        integer, intent(inout) :: status
        gradient = 0 * xyz
        status = -1
        if (.false. .and. same_type_as(self, self)) status = -1
    end subroutine

    ! --------------------------------------------------------------------------------------------------------------------- parts

    ! The text of a part file.
    subroutine part_parse(self, text, options, failure)
        class(rv_part), intent(inout) :: self
        character(*), intent(in) :: text
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_part_parse(text//c_null_char, handle_of(options), made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! A part file.
    subroutine part_load(self, path, options, failure)
        class(rv_part), intent(inout) :: self
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_part_load(trim(path)//c_null_char, handle_of(options), made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! One solid of R-functions at most, and any number of solids built from edges.
    subroutine part_of(self, solids, failure)
        class(rv_part), intent(inout) :: self
        type(rv_solid), intent(in) :: solids(:)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        type(c_ptr) :: handles(size(solids))
        integer :: i
        handles = [(solids(i)%handle, i=1, size(solids))]
        status = rv_part_new(handles, size(solids, kind=c_size_t), made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    subroutine part_units(self, units, failure)
        class(rv_part), intent(in) :: self
        character(*), intent(in) :: units
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_set_units(self%handle, trim(units)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    ! Empty where none was said.
    function part_said_units(self, failure) result(text)
        class(rv_part), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_part_units(self%handle, chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    subroutine part_rsystem(self, rsystem, failure)
        class(rv_part), intent(in) :: self
        character(*), intent(in) :: rsystem
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_set_rsystem(self%handle, trim(rsystem)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    ! Corners in columns: where to cut off what may be infinite.
    subroutine part_domain(self, bounds, failure)
        class(rv_part), intent(in) :: self
        real(c_double), intent(in) :: bounds(3, 2)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_set_domain(self%handle, bounds, error)
        call keep(status, error, failure)
    end subroutine

    ! Adds faces to a group, by a pattern of names.
    subroutine part_group(self, name, faces, failure)
        class(rv_part), intent(in) :: self
        character(*), intent(in) :: name, faces
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_group(self%handle, trim(name)//c_null_char, trim(faces)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    ! JSON.
    function part_info(self, failure) result(info)
        class(rv_part), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: info
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_part_info(self%handle, text, error)
        info = taken(text)
        call keep(status, error, failure)
    end function

    ! A text of the library's, which is freed.
    function taken(text) result(chars)
        type(c_ptr), intent(in) :: text
        character(:), allocatable :: chars
        type(c_ptr) :: c, error
        integer(c_int) :: status
        c = c_null_ptr
        if (c_associated(text)) then
            status = rv_text_chars(text, c, error)
            if (status /= rv_good) call rv_error_free(error)
        end if
        chars = text_of(c)
        call rv_text_free(text)
    end function

    ! Values at points xyz(3, n).
    subroutine part_values(self, xyz, values, failure)
        class(rv_part), intent(in) :: self
        real(c_double), intent(in) :: xyz(:, :)
        real(c_double), intent(out) :: values(:)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_values(self%handle, size(values, kind=c_size_t), xyz, values, error)
        call keep(status, error, failure)
    end subroutine

    ! Gradients (3, n) at points xyz(3, n).
    subroutine part_gradients(self, xyz, gradients, failure)
        class(rv_part), intent(in) :: self
        real(c_double), intent(in) :: xyz(:, :)
        real(c_double), intent(out) :: gradients(:, :)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_gradients(self%handle, size(gradients, 2, kind=c_size_t), xyz, gradients, error)
        call keep(status, error, failure)
    end subroutine

    ! Faces at points xyz(3, n), from 1; 0 where none decides.
    subroutine part_faces(self, xyz, faces, failure)
        class(rv_part), intent(in) :: self
        real(c_double), intent(in) :: xyz(:, :)
        integer(c_int32_t), intent(out) :: faces(:)
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        faces = -1
        status = rv_part_faces(self%handle, size(faces, kind=c_size_t), xyz, faces, error)
        faces = faces + 1
        call keep(status, error, failure)
    end subroutine

    ! How many faces its function has.
    function part_face_count(self, failure) result(count)
        class(rv_part), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: count
        integer(c_size_t) :: n
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_face_count(self%handle, n, error)
        count = int(n)
        call keep(status, error, failure)
    end function

    ! The name of one of them, from 1.
    function part_face_name(self, index, failure) result(name)
        class(rv_part), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: name
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_part_face_name(self%handle, int(index, c_size_t) - 1, text, error)
        name = taken(text)
        call keep(status, error, failure)
    end function

    ! A status of rv_short is a mesh, too: its shortfalls say why.
    subroutine part_mesh(self, mesh, options, failure)
        class(rv_part), intent(in) :: self
        class(rv_mesh), intent(inout) :: mesh
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_part_mesh(self%handle, handle_of(options), made, error)
        call mesh%free()
        mesh%handle = made
        call keep(status, error, failure)
    end subroutine

    ! About how many triangles that mesh will have.
    function part_expected_triangles(self, options, failure) result(n)
        class(rv_part), intent(in) :: self
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        integer(c_size_t) :: n
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_expected_triangles(self%handle, handle_of(options), n, error)
        call keep(status, error, failure)
    end function

    ! About how many triangles the mesh of a file will have.
    function rv_expected_of_file(path, options, failure) result(n)
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        integer(c_size_t) :: n
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_expected_triangles_file(trim(path)//c_null_char, handle_of(options), n, error)
        call keep(status, error, failure)
    end function

    ! Every stage of every method measured on it, as JSON.
    function part_compare(self, options, failure) result(report)
        class(rv_part), intent(in) :: self
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: report
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_compare(self%handle, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end function

    ! R-systems compared on it, as JSON.
    function part_compare_rsystems(self, options, failure) result(report)
        class(rv_part), intent(in) :: self
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: report
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_compare_rsystems(self%handle, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end function

    ! Every method measured on the samples that come with the library, as JSON.
    subroutine rv_samples_compared(report, options, failure)
        character(:), allocatable, intent(out) :: report
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_compare_samples(handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! Faces, edges and vertices that are found in a surface of points (3, n) and triangles (3, m), as JSON.
    subroutine rv_triangles_told(report, points, triangles, options, failure)
        character(:), allocatable, intent(out) :: report
        real(c_double), intent(in), target, contiguous :: points(:, :)
        integer(c_int32_t), intent(in) :: triangles(:, :)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_surface) :: surface
        integer(c_int32_t), allocatable, target :: numbers(:, :)
        type(c_ptr) :: text, error
        integer(c_int) :: status
        surface%points = c_loc(points)
        surface%point_count = size(points, 2, kind=c_size_t)
        allocate (numbers, source=triangles - 1)
        surface%triangles = c_loc(numbers)
        surface%triangle_count = size(triangles, 2, kind=c_size_t)
        status = rv_triangles_info(surface, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! The same of a file of triangles.
    subroutine rv_triangles_told_of_file(report, path, options, failure)
        character(:), allocatable, intent(out) :: report
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_triangles_info_file(trim(path)//c_null_char, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! A surface of points (3, n) and triangles (3, m) measured beside what methods make of it, as JSON.
    subroutine rv_triangles_compared(report, points, triangles, options, failure)
        character(:), allocatable, intent(out) :: report
        real(c_double), intent(in), target, contiguous :: points(:, :)
        integer(c_int32_t), intent(in) :: triangles(:, :)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_surface) :: surface
        integer(c_int32_t), allocatable, target :: numbers(:, :)
        type(c_ptr) :: text, error
        integer(c_int) :: status
        surface%points = c_loc(points)
        surface%point_count = size(points, 2, kind=c_size_t)
        allocate (numbers, source=triangles - 1)
        surface%triangles = c_loc(numbers)
        surface%triangle_count = size(triangles, 2, kind=c_size_t)
        status = rv_compare_triangles(surface, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! The same of a file of triangles.
    subroutine rv_triangles_compared_of_file(report, path, options, failure)
        character(:), allocatable, intent(out) :: report
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_compare_triangles_file(trim(path)//c_null_char, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! What is wrong with the model of a STEP file, as JSON; a status of rv_short where anything is.
    subroutine rv_step_checked(report, path, options, failure)
        character(:), allocatable, intent(out) :: report
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_step_check(trim(path)//c_null_char, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! What is in the model of a STEP file, as JSON; a status of rv_short where something was not understood.
    subroutine rv_step_told(info, path, options, failure)
        character(:), allocatable, intent(out) :: info
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_step_info(trim(path)//c_null_char, handle_of(options), text, error)
        info = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! A plan of bricks for a part file, in a folder.
    subroutine rv_planned(folder, path, counts, options, failure)
        character(*), intent(in) :: folder, path
        integer, intent(in) :: counts(3)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_bricks_plan(trim(path)//c_null_char, int(counts, c_int32_t), &
            handle_of(options), trim(folder)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    ! Makes the bricks of a plan, or those of share(1) of share(2) in round share(3); how many pieces were made.
    function rv_made(folder, share, options, failure) result(n)
        character(*), intent(in) :: folder
        integer, intent(in), optional :: share(3)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        integer(c_size_t) :: n
        type(c_ptr) :: error
        integer(c_int) :: status
        if (present(share)) then
            status = rv_bricks_make(trim(folder)//c_null_char, c_share(share(1), share(2), share(3)), handle_of(options), n, error)
        else
            status = rv_bricks_make(trim(folder)//c_null_char, options=handle_of(options), made=n, error=error)
        end if
        call keep(status, error, failure)
    end function

    ! Writes the mesh of all bricks to a file, and tells its report as JSON.
    subroutine rv_merged(report, folder, path, options, failure)
        character(:), allocatable, intent(out) :: report
        character(*), intent(in) :: folder, path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_bricks_merge(trim(folder)//c_null_char, trim(path)//c_null_char, handle_of(options), text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! The function on a regular grid: options cells or step, margin, gradient.
    subroutine part_sample(self, samples, options, failure)
        class(rv_part), intent(in) :: self
        type(rv_samples), intent(inout) :: samples
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error, other
        integer(c_int) :: status, framed
        status = rv_part_sample(self%handle, handle_of(options), made, error)
        call samples%free()
        samples%handle = made
        if (c_associated(made)) then
            framed = rv_samples_frame(made, samples%counts, samples%origin, samples%step, other)
            if (framed /= rv_good) call rv_error_free(other)
        end if
        call keep(status, error, failure)
    end subroutine

    ! Values (x, y, z).
    function samples_values(self, failure) result(values)
        class(rv_samples), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: values(:, :, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_samples_values(self%handle, data, n, error)
        call c_f_pointer(data, values, merge(self%counts, [0_c_size_t, 0_c_size_t, 0_c_size_t], n > 0))
        call keep(status, error, failure)
    end function

    ! Gradients (3, x, y, z); empty where the option gradient was not true.
    function samples_gradients(self, failure) result(xyz)
        class(rv_samples), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: xyz(:, :, :, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_samples_gradients(self%handle, data, n, error)
        call c_f_pointer(data, xyz, [3_c_size_t, merge(self%counts, [0_c_size_t, 0_c_size_t, 0_c_size_t], n > 0)])
        call keep(status, error, failure)
    end function

    ! By extension: vti, or npy for values alone.
    subroutine samples_write(self, path, options, failure)
        class(rv_samples), intent(in) :: self
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_samples_write(self%handle, trim(path)//c_null_char, handle_of(options), error)
        call keep(status, error, failure)
    end subroutine

    subroutine samples_free(self)
        class(rv_samples), intent(inout) :: self
        call rv_samples_free(self%handle)
        self%handle = c_null_ptr
        self%counts = 0
    end subroutine

    subroutine part_write_step(self, path, failure)
        class(rv_part), intent(in) :: self
        character(*), intent(in) :: path
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_write_step(self%handle, trim(path)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    ! By extension: step, stp, vm or 3mf.
    subroutine part_write(self, path, failure)
        class(rv_part), intent(in) :: self
        character(*), intent(in) :: path
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_part_write(self%handle, trim(path)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    subroutine part_free(self)
        class(rv_part), intent(inout) :: self
        call rv_part_free(self%handle)
        self%handle = c_null_ptr
    end subroutine

    ! -------------------------------------------------------------------------------------------------------------------- meshes

    ! Meshes a part file, a STEP file, or a file of triangles, anew.
    subroutine rv_mesh_of_file(mesh, path, options, failure)
        class(rv_mesh), intent(inout) :: mesh
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_mesh_file(trim(path)//c_null_char, handle_of(options), made, error)
        call mesh%free()
        mesh%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Reads a file of triangles as it is.
    subroutine rv_read_triangles(mesh, path, options, failure)
        class(rv_mesh), intent(inout) :: mesh
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        status = rv_mesh_read(trim(path)//c_null_char, handle_of(options), made, error)
        call mesh%free()
        mesh%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Meshes a surface anew: points (3, n), triangles (3, m) from 1.
    subroutine rv_mesh_of_triangles(mesh, points, triangles, options, failure)
        class(rv_mesh), intent(inout) :: mesh
        real(c_double), intent(in), target, contiguous :: points(:, :)
        integer(c_int32_t), intent(in) :: triangles(:, :)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_surface) :: surface
        integer(c_int32_t), allocatable, target :: numbers(:, :)
        type(c_ptr) :: made, error
        integer(c_int) :: status
        surface%points = c_loc(points)
        surface%point_count = size(points, 2, kind=c_size_t)
        allocate (numbers, source=triangles - 1)
        surface%triangles = c_loc(numbers)
        surface%triangle_count = size(triangles, 2, kind=c_size_t)
        status = rv_remesh(surface, handle_of(options), made, error)
        call mesh%free()
        mesh%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Sets right what is wrong with a surface.
    subroutine rv_healed(mesh, points, triangles, options, failure)
        class(rv_mesh), intent(inout) :: mesh
        real(c_double), intent(in), target, contiguous :: points(:, :)
        integer(c_int32_t), intent(in) :: triangles(:, :)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_surface) :: surface
        integer(c_int32_t), allocatable, target :: numbers(:, :)
        type(c_ptr) :: made, error
        integer(c_int) :: status
        surface%points = c_loc(points)
        surface%point_count = size(points, 2, kind=c_size_t)
        allocate (numbers, source=triangles - 1)
        surface%triangles = c_loc(numbers)
        surface%triangle_count = size(triangles, 2, kind=c_size_t)
        status = rv_heal(surface, handle_of(options), made, error)
        call mesh%free()
        mesh%handle = made
        call keep(status, error, failure)
    end subroutine

    ! Measures a surface, against a part where one is given: JSON.
    subroutine rv_checked(report, points, triangles, part, failure)
        character(:), allocatable, intent(out) :: report
        real(c_double), intent(in), target, contiguous :: points(:, :)
        integer(c_int32_t), intent(in) :: triangles(:, :)
        type(rv_part), intent(in), optional :: part
        type(rv_failure), intent(out), optional :: failure
        type(c_surface) :: surface
        integer(c_int32_t), allocatable, target :: numbers(:, :)
        type(c_ptr) :: against, text, error
        integer(c_int) :: status
        surface%points = c_loc(points)
        surface%point_count = size(points, 2, kind=c_size_t)
        allocate (numbers, source=triangles - 1)
        surface%triangles = c_loc(numbers)
        surface%triangle_count = size(triangles, 2, kind=c_size_t)
        against = c_null_ptr
        if (present(part)) against = part%handle
        status = rv_check(surface, against, c_null_ptr, text, error)
        report = taken(text)
        call keep(status, error, failure)
    end subroutine

    ! Coordinates (3, n).
    function mesh_points(self, failure) result(xyz)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: xyz(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_points(self%handle, data, n, error)
        call c_f_pointer(data, xyz, [3_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! Outward unit normals of the triangles (3, m).
    function mesh_normals(self, failure) result(xyz)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: xyz(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_normals(self%handle, data, n, error)
        call c_f_pointer(data, xyz, [3_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! A copy of numbers from 0 as numbers from `first`, which is 1 where it is not said.
    function numbered(data, n, first) result(numbers)
        type(c_ptr), intent(in) :: data
        integer(c_size_t), intent(in) :: n
        integer, intent(in), optional :: first
        integer(c_int32_t), allocatable :: numbers(:)
        integer(c_int32_t), pointer :: lent(:)
        allocate (numbers(n))
        if (n == 0) return
        call c_f_pointer(data, lent, [n])
        numbers = lent + 1
        if (present(first)) numbers = lent + first
    end function

    ! Points of triangles (3, m), counter-clockwise from outside.
    function mesh_triangles(self, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_triangles(self%handle, data, n, error)
        numbers = reshape(numbered(data, 3 * n, first), [3_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! Points of edges (2, k): between faces, within them, and open ones.
    function mesh_feature_edges(self, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_feature_edges(self%handle, data, n, error)
        numbers = reshape(numbered(data, 2 * n, first), [2_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! The face of each triangle.
    function mesh_labels(self, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_labels(self%handle, data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    ! Points where borders of faces end or meet, and apexes.
    function mesh_corners(self, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_corners(self%handle, data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    ! Triangles of a group, a face, or faces whose names fit a pattern.
    function mesh_triangles_of(self, name, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        character(*), intent(in) :: name
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_triangles_of(self%handle, trim(name)//c_null_char, data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    ! Points of these triangles.
    function mesh_nodes_of(self, name, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        character(*), intent(in) :: name
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_nodes_of(self%handle, trim(name)//c_null_char, data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    ! Closed lines of the borders of a plane figure; none for any other mesh.
    function mesh_contour_count(self, failure) result(n)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_mesh_contour_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! The points of a closed line, by its number from 1; the figure is on the left.
    function mesh_contour(self, index, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_contour(self%handle, int(index - 1, c_size_t), data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    ! For each of these points the border of the edge from it to the next one.
    function mesh_contour_borders(self, index, first, failure) result(numbers)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_contour_borders(self%handle, int(index - 1, c_size_t), data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    function mesh_border_count(self, failure) result(n)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_mesh_border_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! By its number, from 1.
    function mesh_border_name(self, index, failure) result(text)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_border_name(self%handle, int(index - 1, c_size_t), chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    function mesh_face_count(self, failure) result(n)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_mesh_face_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! By its number, from 1.
    function mesh_face_name(self, index, failure) result(text)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_face_name(self%handle, int(index - 1, c_size_t), chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    function mesh_group_count(self, failure) result(n)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_mesh_group_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! By its number, from 1.
    function mesh_group_name(self, index, failure) result(text)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_group_name(self%handle, int(index - 1, c_size_t), chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    function mesh_shortfall_count(self, failure) result(n)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_mesh_shortfall_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! By its number, from 1.
    function mesh_shortfall(self, index, failure) result(text)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_shortfall(self%handle, int(index - 1, c_size_t), chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    function mesh_warning_count(self, failure) result(n)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_mesh_warning_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! By its number, from 1.
    function mesh_warning(self, index, failure) result(text)
        class(rv_mesh), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_warning(self%handle, int(index - 1, c_size_t), chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    ! JSON.
    function mesh_report(self, failure) result(text)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_report(self%handle, chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    ! Closed (or meant to be open), a manifold, oriented, free of self-intersections.
    function mesh_is_sound(self, failure) result(is)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        logical :: is
        type(c_ptr) :: error
        integer(c_int) :: sound, status
        status = rv_mesh_is_sound(self%handle, sound, error)
        is = status == rv_good .and. sound == 1
        call keep(status, error, failure)
    end function

    ! Empty where the part has none.
    function mesh_units(self, failure) result(text)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_mesh_units(self%handle, chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    ! Another mesh with one face made anew at the option size; all other faces stay as they are.
    subroutine mesh_remesh_face(self, made, face, options, failure)
        class(rv_mesh), intent(in) :: self
        type(rv_mesh), intent(out) :: made
        character(*), intent(in) :: face
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_mesh_remesh_face(self%handle, trim(face)//c_null_char, handle_of(options), made%handle, error)
        call keep(status, error, failure)
    end subroutine

    ! HTML.
    function mesh_page(self, title, failure) result(html)
        class(rv_mesh), intent(in) :: self
        character(*), intent(in) :: title
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: html
        type(c_ptr) :: text, error
        integer(c_int) :: status
        status = rv_mesh_page(self%handle, trim(title)//c_null_char, text, error)
        html = taken(text)
        call keep(status, error, failure)
    end function

    ! Of each node the two principal curvatures (2, n), 1 over length, as magnitudes with the larger one first.
    function mesh_curvatures(self, failure) result(principal)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: principal(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_curvatures(self%handle, data, n, error)
        call c_f_pointer(data, principal, [2_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! By how much the angles around each node differ from those where it is flat, radians (n).
    function mesh_angle_defects(self, failure) result(radians)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: radians(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_angle_defects(self%handle, data, n, error)
        call c_f_pointer(data, radians, [n])
        call keep(status, error, failure)
    end function

    ! 0 for a regular node, 1 on a crease, 2 for a corner.
    function mesh_node_classes(self, failure) result(classes)
        class(rv_mesh), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer, allocatable :: classes(:)
        integer(c_int8_t), pointer :: lent(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_node_classes(self%handle, data, n, error)
        allocate (classes(n))
        if (n > 0) then
            call c_f_pointer(data, lent, [n])
            classes = lent
        end if
        call keep(status, error, failure)
    end function

    ! How far each node is from the surface of a part; infinite where it is far from all of it.
    function mesh_distances(self, part, options, failure) result(distances)
        class(rv_mesh), intent(in) :: self
        type(rv_part), intent(in) :: part
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        real(c_double), allocatable :: distances(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_mesh_points(self%handle, data, n, error)
        allocate (distances(n))
        if (status == rv_good) status = rv_mesh_distances(self%handle, part%handle, handle_of(options), distances, error)
        call keep(status, error, failure)
    end function

    ! A picture; rv_mesh_picture of rvachev.h describes the options. The part is for the color distance.
    subroutine mesh_draw(self, picture, options, part, failure)
        class(rv_mesh), intent(in) :: self
        type(rv_picture), intent(out) :: picture
        type(rv_options), intent(in), optional :: options
        type(rv_part), intent(in), optional :: part
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: against, data, error
        integer(c_int) :: status
        against = c_null_ptr
        if (present(part)) against = part%handle
        status = rv_mesh_picture(self%handle, against, handle_of(options), picture%handle, error)
        if (status == rv_good) status = rv_picture_pixels(picture%handle, data, picture%width, picture%height, error)
        call keep(status, error, failure)
    end subroutine

    ! Red, green, blue and opacity (4, width, height) from the top left: 0 to 255, of which 128 and more are negative here.
    function picture_pixels(self, failure) result(rgba)
        class(rv_picture), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer(c_int8_t), pointer :: rgba(:, :, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: width, height
        integer(c_int) :: status
        status = rv_picture_pixels(self%handle, data, width, height, error)
        call c_f_pointer(data, rgba, [4_c_size_t, width, height])
        call keep(status, error, failure)
    end function

    ! PNG.
    subroutine picture_write(self, path, failure)
        class(rv_picture), intent(in) :: self
        character(*), intent(in) :: path
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_picture_write(self%handle, trim(path)//c_null_char, error)
        call keep(status, error, failure)
    end subroutine

    subroutine picture_free(self)
        class(rv_picture), intent(inout) :: self
        call rv_picture_free(self%handle)
        self%handle = c_null_ptr
    end subroutine

    ! Prisms in layers: what a face sweeps along a vector, or the room to another face that matches; one of the two is given.
    subroutine mesh_sweep(self, prisms, face, layers, along, to, failure)
        class(rv_mesh), intent(in) :: self
        type(rv_prisms), intent(out) :: prisms
        character(*), intent(in) :: face
        integer, intent(in) :: layers
        real(c_double), intent(in), optional :: along(3)
        character(*), intent(in), optional :: to
        type(rv_failure), intent(out), optional :: failure
        type(c_sweep) :: sweep
        type(c_ptr) :: error
        real(c_double), target :: vector(3)
        character(kind=c_char, len=:), allocatable, target :: bottom, top
        integer(c_int) :: status
        bottom = trim(face)//c_null_char
        sweep%face = c_loc(bottom)
        sweep%layers = max(layers, 0)
        if (present(along)) then
            vector = along
            sweep%along = c_loc(vector)
        end if
        if (present(to)) then
            top = trim(to)//c_null_char
            sweep%to = c_loc(top)
        end if
        status = rv_mesh_sweep(self%handle, sweep, prisms%handle, error)
        call keep(status, error, failure)
    end subroutine

    ! Coordinates (3, n).
    function prisms_points(self, failure) result(xyz)
        class(rv_prisms), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: xyz(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_prisms_points(self%handle, data, n, error)
        call c_f_pointer(data, xyz, [3_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! Points of prisms (6, m): three of the bottom, and those across from them.
    function prisms_cells(self, first, failure) result(numbers)
        class(rv_prisms), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_prisms_cells(self%handle, data, n, error)
        numbers = reshape(numbered(data, 6 * n, first), [6_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! Points of hexahedra (8, m): four of the bottom, and those across from them; none unless these were paired.
    function prisms_hexahedra(self, first, failure) result(numbers)
        class(rv_prisms), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_prisms_hexahedra(self%handle, data, n, error)
        numbers = reshape(numbered(data, 8 * n, first), [8_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! Hexahedra in place of pairs of prisms, at most `off` degrees (45) off rectangles; cells are those without a partner.
    subroutine prisms_pair(self, paired, off, failure)
        class(rv_prisms), intent(in) :: self
        type(rv_prisms), intent(out) :: paired
        real(c_double), intent(in), optional :: off
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        real(c_double) :: most
        integer(c_int) :: status
        most = 45
        if (present(off)) most = off
        status = rv_prisms_pair(self%handle, most, paired%handle, error)
        call keep(status, error, failure)
    end subroutine

    ! Values at a mesh's points, carried to other points (3, k): each has the value of the nearest point of the mesh.
    subroutine mesh_carry(self, values, xyz, carried, failure)
        class(rv_mesh), intent(in) :: self
        real(c_double), intent(in), target, contiguous :: values(:), xyz(:, :)
        real(c_double), intent(out), allocatable, target :: carried(:)
        type(rv_failure), intent(out), optional :: failure
        type(c_carry) :: what
        type(c_ptr) :: points, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        allocate(carried(size(xyz, 2)))
        status = rv_mesh_points(self%handle, points, n, error)
        if (status /= rv_good) then
            call keep(status, error, failure)
            return
        end if
        ! Of too few values NULL is made, which is told as an error.
        if (size(values) >= n) what%values = c_loc(values)
        what%width = 1
        what%xyz = c_loc(xyz)
        what%count = size(xyz, 2)
        what%carried = c_loc(carried)
        status = rv_mesh_carry(self%handle, what, error)
        call keep(status, error, failure)
    end subroutine

    ! Meshes joined to one where their nodes match, up to the option 'within'.
    subroutine mesh_join(self, meshes, options, failure)
        class(rv_mesh), intent(inout) :: self
        type(rv_mesh), intent(in) :: meshes(:)
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: made, error
        integer(c_int) :: status
        type(c_ptr) :: handles(size(meshes))
        integer :: i
        handles = [(meshes(i)%handle, i=1, size(meshes))]
        status = rv_mesh_join(handles, size(meshes, kind=c_size_t), handle_of(options), made, error)
        call self%free()
        self%handle = made
        call keep(status, error, failure)
    end subroutine

    ! The points (3, k) of the shortest way over the mesh between the points of it that are nearest to two points; and its length.
    subroutine mesh_path(self, from, to, xyz, length, failure)
        class(rv_mesh), intent(in) :: self
        real(c_double), intent(in) :: from(3), to(3)
        real(c_double), intent(out), allocatable :: xyz(:, :)
        real(c_double), intent(out) :: length
        type(rv_failure), intent(out), optional :: failure
        real(c_double), pointer :: lent(:, :)
        type(c_ptr) :: path, data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        length = 0
        status = rv_mesh_path(self%handle, from, to, path, error)
        if (status == rv_good) status = rv_path_length(path, length, error)
        if (status == rv_good) status = rv_path_points(path, data, n, error)
        if (status == rv_good) then
            call c_f_pointer(data, lent, [3_c_size_t, n])
            xyz = lent
        else
            allocate(xyz(3, 0))
        end if
        call rv_path_free(path)
        call keep(status, error, failure)
    end subroutine

    ! Points of sides on the boundary (4, k); a triangle has its third one twice.
    function prisms_sides(self, first, failure) result(numbers)
        class(rv_prisms), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:, :)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_prisms_sides(self%handle, data, n, error)
        numbers = reshape(numbered(data, 4 * n, first), [4_c_size_t, n])
        call keep(status, error, failure)
    end function

    ! The name of each side.
    function prisms_labels(self, first, failure) result(numbers)
        class(rv_prisms), intent(in) :: self
        integer, intent(in), optional :: first
        type(rv_failure), intent(out), optional :: failure
        integer(c_int32_t), allocatable :: numbers(:)
        type(c_ptr) :: data, error
        integer(c_size_t) :: n
        integer(c_int) :: status
        status = rv_prisms_labels(self%handle, data, n, error)
        numbers = numbered(data, n, first)
        call keep(status, error, failure)
    end function

    function prisms_name_count(self, failure) result(n)
        class(rv_prisms), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        integer :: n
        type(c_ptr) :: error
        integer(c_size_t) :: count
        integer(c_int) :: status
        status = rv_prisms_name_count(self%handle, count, error)
        n = merge(int(count), 0, status == rv_good)
        call keep(status, error, failure)
    end function

    ! By its number, from 1.
    function prisms_name(self, index, failure) result(text)
        class(rv_prisms), intent(in) :: self
        integer, intent(in) :: index
        type(rv_failure), intent(out), optional :: failure
        character(:), allocatable :: text
        type(c_ptr) :: chars, error
        integer(c_int) :: status
        status = rv_prisms_name(self%handle, int(index - 1, c_size_t), chars, error)
        text = text_of(chars)
        call keep(status, error, failure)
    end function

    function prisms_volume(self, failure) result(volume)
        class(rv_prisms), intent(in) :: self
        type(rv_failure), intent(out), optional :: failure
        real(c_double) :: volume
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_prisms_volume(self%handle, volume, error)
        call keep(status, error, failure)
    end function

    ! By extension: vtu, msh or inp.
    subroutine prisms_write(self, path, options, failure)
        class(rv_prisms), intent(in) :: self
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_prisms_write(self%handle, trim(path)//c_null_char, handle_of(options), error)
        call keep(status, error, failure)
    end subroutine

    subroutine prisms_free(self)
        class(rv_prisms), intent(inout) :: self
        call rv_prisms_free(self%handle)
        self%handle = c_null_ptr
    end subroutine

    ! By extension.
    subroutine mesh_write(self, path, options, failure)
        class(rv_mesh), intent(in) :: self
        character(*), intent(in) :: path
        type(rv_options), intent(in), optional :: options
        type(rv_failure), intent(out), optional :: failure
        type(c_ptr) :: error
        integer(c_int) :: status
        status = rv_mesh_write(self%handle, trim(path)//c_null_char, handle_of(options), error)
        call keep(status, error, failure)
    end subroutine

    subroutine mesh_free(self)
        class(rv_mesh), intent(inout) :: self
        call rv_mesh_free(self%handle)
        self%handle = c_null_ptr
    end subroutine
end module
