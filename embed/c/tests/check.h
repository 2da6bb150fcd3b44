/* What the tests share: checks that tell where they failed. C99 and C++. */
#ifndef CHECK_H
#define CHECK_H

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halfdome.h"

#define CHECK(condition)                                                                              \
    do {                                                                                              \
        if (!(condition)) {                                                                           \
            fprintf(stderr, "%s:%d: %s: %s\n", __FILE__, __LINE__, #condition, hd_last_error());      \
            exit(1);                                                                                  \
        }                                                                                             \
    } while (0)

#define OK(call) CHECK((call) == HD_OK)

/* The call fails with this status, and a message with these words. */
#define FAILS(status, words, call)                             \
    do {                                                       \
        CHECK((call) == (status));                             \
        CHECK(strstr(hd_last_error(), (words)) != NULL);       \
    } while (0)

static inline hd_mesh mesh_of(const float *positions, size_t vertex_count, const uint32_t *indices, size_t index_count) {
    hd_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = positions;
    mesh.vertex_count = vertex_count;
    mesh.indices = indices;
    mesh.index_count = index_count;
    return mesh;
}

static inline hd_ray ray_of(float x, float y, float z, float dx, float dy, float dz) {
    hd_ray ray;
    ray.origin[0] = x;
    ray.origin[1] = y;
    ray.origin[2] = z;
    ray.t_min = 0.0f;
    ray.direction[0] = dx;
    ray.direction[1] = dy;
    ray.direction[2] = dz;
    ray.t_max = INFINITY;
    return ray;
}

/* An item of nothing yet. */
static inline hd_item empty_item(void) {
    hd_item item;
    memset(&item, 0, sizeof item);
    item.struct_size = sizeof item;
    return item;
}

/* A tree of COLUMNS by COLUMNS squares of size 1 in z = 0, two triangles each. */
#define COLUMNS 20
#define SQUARES (COLUMNS * COLUMNS)

static inline hd_tree *floor_tree(uint32_t quality) {
    static float positions[(COLUMNS + 1) * (COLUMNS + 1) * 3];
    static uint32_t indices[SQUARES * 6];
    size_t vertex = 0, index = 0;
    for (uint32_t y = 0; y <= COLUMNS; y++) {
        for (uint32_t x = 0; x <= COLUMNS; x++) {
            positions[vertex++] = (float)x;
            positions[vertex++] = (float)y;
            positions[vertex++] = 0.0f;
        }
    }
    for (uint32_t y = 0; y < COLUMNS; y++) {
        for (uint32_t x = 0; x < COLUMNS; x++) {
            uint32_t corner = y * (COLUMNS + 1) + x, across = corner + COLUMNS + 2;
            const uint32_t square[6] = {corner, corner + 1, across, corner, across, across - 1};
            memcpy(indices + index, square, sizeof square);
            index += 6;
        }
    }
    hd_mesh mesh = mesh_of(positions, vertex / 3, indices, index);
    hd_build_options options;
    memset(&options, 0, sizeof options);
    options.struct_size = sizeof options;
    options.quality = quality;
    hd_tree *tree = NULL;
    OK(hd_tree_build(&mesh, &options, &tree));
    CHECK(tree != NULL);
    return tree;
}

/* The hit on the floor that is straight below the square's point (0.75, 0.25), or (0.25, 0.75) for the second half. */
static inline void check_floor(const hd_tree *tree, uint32_t x, uint32_t y, int second) {
    float u = second ? 0.25f : 0.75f;
    hd_ray ray = ray_of((float)x + u, (float)y + 1.0f - u, 2.0f, 0.0f, 0.0f, -0.5f);
    hd_hit hit;
    bool occluded = false;
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.prim_id == 2 * (y * COLUMNS + x) + (second ? 1 : 0));
    /* Both halves begin in the same corner: (1, 0) and (1, 1) are the first one's, (1, 1) and (0, 1) the second's. */
    CHECK(hit.t == 4.0f && hit.u == (second ? 0.25f : 0.5f) && hit.v == (second ? 0.5f : 0.25f));
    OK(hd_occluded(tree, &ray, &occluded));
    CHECK(occluded);
}

#endif
