! What is told of a STEP model, methods compared, and a mesh made brick by brick. Arguments as for models.c.
program models
    use rvachev
    implicit none
    type(rv_part) :: part
    type(rv_options) :: sizes, fine
    type(rv_failure) :: failure
    character(1000) :: ball, bar, cube, folder
    character(:), allocatable :: text
    integer :: some, rest
    call get_command_argument(1, ball)
    call get_command_argument(2, bar)
    call get_command_argument(3, cube)
    call get_command_argument(4, folder)
    call rv_step_checked(text, bar, failure=failure)
    print '(a, i0, 2a)', 'bar_check ', failure%status, ' ', text
    call rv_step_told(text, ball, failure=failure)
    print '(a, i0, 2a)', 'ball_info ', failure%status, ' ', text
    call sizes%set('size', '0.1')
    call part%load(cube)
    print '(2a)', 'compared 0 ', part%compare(sizes)
    call fine%set('size', '0.04')
    call rv_planned(trim(folder)//'/plan', cube, [2, 1, 1], fine)
    some = int(rv_made(trim(folder)//'/plan', [1, 1, 1]))
    rest = int(rv_made(trim(folder)//'/plan'))
    print '(2(a, i0))', 'bricks made ', some + rest, ' again ', rv_made(trim(folder)//'/plan')
    call rv_merged(text, trim(folder)//'/plan', trim(folder)//'/cube.stl', failure=failure)
    print '(a, i0, 2a)', 'merged ', failure%status, ' ', text
    call part%free(); call sizes%free(); call fine%free()
end program
