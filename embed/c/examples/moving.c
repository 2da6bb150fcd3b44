/* A scene that moves, as an engine moves it: a ring of doors turns, rays look for the nearest one, frame by frame. Drawn from
 * above: o a door, @ the door that is nearest to the player (P), * where his line of sight to the lamp (L) ends.
 *
 *     cargo build --release -p halfdome-c
 *     gcc -std=c99 -Iembed/c/include embed/c/examples/moving.c target/release/libhalfdome_c.a -lpthread -ldl -lm */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "halfdome.h"

enum { DOORS = 12, FRAMES = 4, WIDTH = 61, HEIGHT = 23 };

/* A door stands in the plane x = 0: 2 wide along z, 2 high along y. */
static const float positions[][3] = {{0, 0, -1}, {0, 0, 1}, {0, 2, 1}, {0, 2, -1}};
static const uint16_t indices[] = {0, 1, 2, 0, 2, 3};

static void stop_if(hd_status status) {
    if (status != HD_OK) {
        fprintf(stderr, "%s: %s\n", hd_status_name(status), hd_last_error());
        exit(1);
    }
}

/* The rows of a matrix that turns a door about y and puts it on a ring of radius 8. */
static void on_ring(float rows[12], float angle) {
    const float c = cosf(angle), s = sinf(angle);
    const float turned[12] = {c, 0, s, 8 * c, 0, 1, 0, 0, -s, 0, c, -8 * s};
    memcpy(rows, turned, sizeof turned);
}

static void put(char picture[HEIGHT][WIDTH + 1], float x, float z, char mark) {
    const int column = WIDTH / 2 + (int)lroundf(3 * x), row = HEIGHT / 2 + (int)lroundf(1.3f * z);
    if (row >= 0 && row < HEIGHT && column >= 0 && column < WIDTH) {
        picture[row][column] = mark;
    }
}

int main(void) {
    hd_mesh mesh;
    memset(&mesh, 0, sizeof mesh);
    mesh.struct_size = sizeof mesh;
    mesh.positions = positions;
    mesh.vertex_count = sizeof positions / sizeof positions[0];
    mesh.indices = indices;
    mesh.index_count = sizeof indices / sizeof indices[0];
    mesh.index_size = sizeof indices[0];
    hd_tree *door;
    stop_if(hd_tree_build(&mesh, NULL, &door));

    /* The scene's own tree is over its items: where these move, it should be built quickly. */
    hd_build_options quickly;
    memset(&quickly, 0, sizeof quickly);
    quickly.struct_size = sizeof quickly;
    quickly.quality = HD_QUALITY_FAST;
    hd_scene *scene;
    stop_if(hd_scene_build(NULL, 0, &quickly, &scene));

    hd_item item;
    memset(&item, 0, sizeof item);
    item.struct_size = sizeof item;
    item.tree = door;
    hd_handle doors[DOORS];
    for (int i = 0; i < DOORS; i++) {
        stop_if(hd_scene_insert(scene, &item, &doors[i]));
    }
    hd_tree_free(door); /* The scene shares it. */

    const float player[3] = {1, 1, 2}, lamp[3] = {-9, 1, -3};
    for (int frame = 0; frame < FRAMES; frame++) {
        char picture[HEIGHT][WIDTH + 1];
        memset(picture, ' ', sizeof picture);
        float rows[12];
        for (int i = 0; i < DOORS; i++) {
            on_ring(rows, 6.2831853f / DOORS * ((float)i + 0.22f * (float)frame));
            stop_if(hd_scene_set_transform(scene, doors[i], rows));
            put(picture, rows[3], rows[11], 'o');
        }
        stop_if(hd_scene_commit(scene, NULL));

        /* Which door is nearest to the player, and where on it. */
        hd_scene_hit nearest;
        float point[3];
        stop_if(hd_scene_closest_point(scene, player, INFINITY, 0, 0, point, &nearest));
        on_ring(rows, 6.2831853f / DOORS * ((float)nearest.item + 0.22f * (float)frame));
        put(picture, rows[3], rows[11], '@');

        /* Whether a door hides the lamp. */
        hd_scene_ray sight;
        memset(&sight, 0, sizeof sight);
        memcpy(sight.ray.origin, player, sizeof player);
        for (int k = 0; k < 3; k++) {
            sight.ray.direction[k] = lamp[k] - player[k];
        }
        sight.ray.t_max = 1;
        hd_scene_hit hit;
        stop_if(hd_scene_intersect(scene, &sight, &hit));
        const bool hidden = hit.hit.prim_id != HD_NO_PRIM;
        put(picture, player[0], player[2], 'P');
        put(picture, lamp[0], lamp[2], 'L');
        if (hidden) {
            const float t = hit.hit.t;
            put(picture, player[0] + t * sight.ray.direction[0], player[2] + t * sight.ray.direction[2], '*');
        }

        printf("Frame %d: door %u is nearest, %.2f away; ", frame, (unsigned)nearest.item, nearest.hit.t);
        if (hidden) {
            printf("door %u hides the lamp.\n", (unsigned)hit.item);
        } else {
            printf("the player sees the lamp.\n");
        }
        for (int row = 0; row < HEIGHT; row++) {
            picture[row][WIDTH] = '\0';
            puts(picture[row]);
        }
    }
    hd_scene_free(scene);
    return 0;
}
