/* A small picture as text: a pyramid on a floor, with the shadow of a lamp.
 *
 *     cargo build --release -p halfdome-c
 *     gcc -std=c99 -Iembed/c/include embed/c/examples/picture.c target/release/libhalfdome_c.a -lpthread -ldl -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halfdome.h"

enum { WIDTH = 72, HEIGHT = 30 };

static const float positions[][3] = {
    {-4, 0, -4}, {4, 0, -4}, {4, 0, 6}, {-4, 0, 6},                          /* the floor's corners */
    {-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, 1.6f, 0},            /* the pyramid's */
};
static const uint32_t indices[] = {0, 2, 1, 0, 3, 2, 4, 8, 5, 5, 8, 6, 6, 8, 7, 7, 8, 4};

static void stop_if(hd_status status) {
    if (status != HD_OK) {
        fprintf(stderr, "%s: %s\n", hd_status_name(status), hd_last_error());
        exit(1);
    }
}

/* How bright a triangle is that the lamp shines on, by the angle. */
static float brightness(uint32_t triangle, const float to_lamp[3]) {
    float edge[2][3], normal[3], dot = 0, lengths = 0, distance = 0;
    for (int k = 0; k < 3; k++) {
        float start = positions[indices[3 * triangle]][k];
        edge[0][k] = positions[indices[3 * triangle + 1]][k] - start;
        edge[1][k] = positions[indices[3 * triangle + 2]][k] - start;
    }
    for (int k = 0; k < 3; k++) {
        int i = (k + 1) % 3, j = (k + 2) % 3;
        normal[k] = edge[0][i] * edge[1][j] - edge[0][j] * edge[1][i];
        dot += normal[k] * to_lamp[k];
        lengths += normal[k] * normal[k];
        distance += to_lamp[k] * to_lamp[k];
    }
    return fabsf(dot) / sqrtf(lengths * distance);
}

int main(void) {
    hd_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = positions[0];
    mesh.vertex_count = sizeof positions / sizeof positions[0];
    mesh.indices = indices;
    mesh.index_count = sizeof indices / sizeof indices[0];
    hd_tree *tree;
    stop_if(hd_tree_build(&mesh, NULL, &tree));

    static hd_ray rays[HEIGHT * WIDTH];
    static hd_hit hits[HEIGHT * WIDTH];
    static bool shadowed[HEIGHT * WIDTH];
    for (int i = 0; i < HEIGHT * WIDTH; i++) {
        const hd_ray ray = {{0.5f, 2.5f, -6}, 0, {0, 0, 1}, INFINITY};
        rays[i] = ray;
        rays[i].direction[0] = 0.9f * ((float)(i % WIDTH) + 0.5f - WIDTH / 2) / WIDTH;
        rays[i].direction[1] = -0.42f - 0.62f * ((float)(i / WIDTH) + 0.5f - HEIGHT / 2) / HEIGHT;
    }
    stop_if(hd_intersect_many(tree, rays, hits, HEIGHT * WIDTH));

    /* From each hit to the lamp; what hit nothing looks at a lamp beside itself. */
    for (int i = 0; i < HEIGHT * WIDTH; i++) {
        const float lamp[3] = {-3, 4, -2};
        const float t = hits[i].prim_id == HD_NO_PRIM ? 0.0f : hits[i].t;
        for (int k = 0; k < 3; k++) {
            rays[i].origin[k] += t * rays[i].direction[k];
            rays[i].direction[k] = lamp[k] - rays[i].origin[k];
        }
        rays[i].t_min = 1e-3f;
        rays[i].t_max = 1.0f;
    }
    stop_if(hd_occluded_many(tree, rays, shadowed, HEIGHT * WIDTH));

    for (int i = 0; i < HEIGHT * WIDTH; i++) {
        char shade = ' ';
        if (hits[i].prim_id != HD_NO_PRIM) {
            const float paint = hits[i].prim_id < 2 ? 0.5f : 1.0f;
            shade = shadowed[i] ? '.' : ":-=+*%#@"[(int)(7.99f * paint * brightness(hits[i].prim_id, rays[i].direction))];
        }
        putchar(shade);
        if (i % WIDTH == WIDTH - 1) {
            putchar('\n');
        }
    }
    hd_tree_free(tree);
    return 0;
}
