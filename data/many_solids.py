# A union of many spheres and capped cylinders, strewn by additive recurrences (no two directions in a simple ratio).

count = 1000

scale = 0.6 * count ** (-1 / 3)


def strewn(i, k):
    return (0.5 + i * (0.8191725133961645, 0.6710436067037893, 0.5497004779019703, 0.8566748838545029,
                       0.733891856627126, 0.6287067210378087, 0.5385972572236101)[k]) % 1


def center(i):
    return (1.8 * strewn(i, 0) - 0.9, 1.8 * strewn(i, 1) - 0.9, 1.8 * strewn(i, 2) - 0.9)


def radius(i):
    return scale * (0.5 + 0.5 * strewn(i, 3))


def direction(i):
    return (strewn(i, 4) - 0.5, strewn(i, 5) - 0.5, strewn(i, 6) + 0.01)


spheres = [sphere(radius(i), at=center(i)).name(f"sphere_{i}") for i in range(0, count, 2)]
posts = [cylinder(0.7 * radius(i), axis=direction(i), at=center(i), height=2 * radius(i) * (0.7 + 0.8 * strewn(i, 4)))
         .name(f"post_{i}") for i in range(1, count, 2)]

part(union(spheres + posts))
