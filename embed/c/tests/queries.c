/* Filters, all hits, closest points, overlaps and refits, of trees and of scenes, with known answers. */
#include "check.h"

enum { LAYERS = 6 };

/* Right triangles (0, 0), (1, 0), (0, 1) at z = 0, -1, -2 … */
static const uint16_t short_indices[3 * LAYERS] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17};

static void place(float corners[LAYERS][3][3], float x) {
    for (int i = 0; i < LAYERS; i++) {
        const float layer[3][3] = {{x, 0, -(float)i}, {x + 1, 0, -(float)i}, {x, 1, -(float)i}};
        memcpy(corners[i], layer, sizeof layer);
    }
}

static hd_mesh layers(float corners[LAYERS][3][3]) {
    hd_mesh mesh = mesh_of(corners[0][0], 3 * LAYERS, NULL, 0);
    mesh.indices = short_indices;
    mesh.index_count = 3 * LAYERS;
    mesh.index_size = 2;
    return mesh;
}

static hd_tree *tree_of_layers(void) {
    static float corners[LAYERS][3][3];
    place(corners, 0);
    const hd_mesh mesh = layers(corners);
    hd_tree *tree = NULL;
    OK(hd_tree_build(&mesh, NULL, &tree));
    return tree;
}

struct verdicts {
    uint32_t of[LAYERS];
    int calls;
};

static uint32_t judge(void *user, const hd_hit *hit) {
    struct verdicts *verdicts = (struct verdicts *)user;
    verdicts->calls++;
    return verdicts->of[hit->prim_id];
}

static uint32_t judge_in_scene(void *user, const hd_scene_hit *hit) {
    return hit->item == 1 ? judge(user, &hit->hit) : (uint32_t)HD_REJECT;
}

/* The layers, and the same ones higher. */
static const float higher[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 10};

static hd_scene *two_of(const hd_tree *tree) {
    hd_item items[2];
    memset(items, 0, sizeof items);
    items[0].struct_size = items[1].struct_size = sizeof items[0];
    items[0].tree = items[1].tree = tree;
    items[1].transforms = higher;
    items[1].transform_count = 1;
    items[1].mask = 2;
    hd_scene *scene = NULL;
    OK(hd_scene_build(items, 2, NULL, &scene));
    return scene;
}

static void filters(void) {
    hd_tree *tree = tree_of_layers();
    hd_scene *scene = two_of(tree);
    const hd_ray ray = ray_of(0.25f, 0.25f, 20.0f, 0, 0, -1);
    hd_scene_ray scene_ray;
    memset(&scene_ray, 0, sizeof scene_ray);
    scene_ray.ray = ray;
    hd_hit hit;
    hd_scene_hit scene_hit;
    bool occluded;

    struct verdicts none = {{HD_REJECT, HD_REJECT, HD_REJECT, HD_REJECT, HD_REJECT, HD_REJECT}, 0};
    OK(hd_intersect_filtered(tree, &ray, judge, &none, &hit));
    CHECK(hit.prim_id == HD_NO_PRIM && none.calls == LAYERS);
    OK(hd_occluded_filtered(tree, &ray, judge, &none, &occluded));
    CHECK(!occluded && none.calls == 2 * LAYERS);
    OK(hd_scene_intersect_filtered(scene, &scene_ray, judge_in_scene, &none, &scene_hit));
    CHECK(scene_hit.hit.prim_id == HD_NO_PRIM && none.calls == 3 * LAYERS);
    OK(hd_scene_occluded_filtered(scene, &scene_ray, judge_in_scene, &none, &occluded));
    CHECK(!occluded);

    struct verdicts third = none;
    third.of[3] = third.of[5] = HD_ACCEPT;
    OK(hd_intersect_filtered(tree, &ray, judge, &third, &hit));
    CHECK(hit.prim_id == 3 && hit.t == 23);
    OK(hd_occluded_filtered(tree, &ray, judge, &third, &occluded));
    CHECK(occluded);
    OK(hd_scene_intersect_filtered(scene, &scene_ray, judge_in_scene, &third, &scene_hit));
    CHECK(scene_hit.hit.prim_id == 3 && scene_hit.item == 1 && scene_hit.hit.t == 13);
    OK(hd_scene_occluded_filtered(scene, &scene_ray, judge_in_scene, &third, &occluded));
    CHECK(occluded);

    /* Whichever it comes to first. */
    struct verdicts any = {{HD_STOP, HD_STOP, HD_STOP, HD_STOP, HD_STOP, HD_STOP}, 0};
    OK(hd_intersect_filtered(tree, &ray, judge, &any, &hit));
    CHECK(any.calls == 1 && hit.prim_id < LAYERS);

    any.of[0] = 7;
    memset(&hit, 0x55, sizeof hit);
    struct verdicts unknown = {{7, 7, 7, 7, 7, 7}, 0};
    FAILS(HD_ERROR_VALUE, "the filter gave 7", hd_intersect_filtered(tree, &ray, judge, &unknown, &hit));
    CHECK(unknown.calls == 1 && hit.prim_id == 0x55555555);
    FAILS(HD_ERROR_NULL, "filter is NULL", hd_intersect_filtered(tree, &ray, NULL, NULL, &hit));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_intersect_filtered(NULL, &ray, judge, &any, &hit));
    FAILS(HD_ERROR_NULL, "ray is NULL", hd_intersect_filtered(tree, NULL, judge, &any, &hit));
    FAILS(HD_ERROR_NULL, "hit is NULL", hd_intersect_filtered(tree, &ray, judge, &any, NULL));
    FAILS(HD_ERROR_NULL, "occluded is NULL", hd_scene_occluded_filtered(scene, &scene_ray, judge_in_scene, &any, NULL));
    scene_ray.time = NAN;
    FAILS(HD_ERROR_VALUE, "NaN", hd_scene_intersect_filtered(scene, &scene_ray, judge_in_scene, &any, &scene_hit));
    hd_scene_free(scene);
    hd_tree_free(tree);
}

static void all_hits(void) {
    hd_tree *tree = tree_of_layers();
    hd_scene *scene = two_of(tree);
    const hd_ray ray = ray_of(0.25f, 0.25f, 20.0f, 0, 0, -1);
    hd_scene_ray scene_ray;
    memset(&scene_ray, 0, sizeof scene_ray);
    scene_ray.ray = ray;
    hd_hit hits[LAYERS + 2];
    hd_scene_hit scene_hits[2 * LAYERS];
    size_t count = 99;
    OK(hd_nearest_hits(tree, &ray, NULL, 0, &count));
    CHECK(count == LAYERS);
    OK(hd_nearest_hits(tree, &ray, hits, LAYERS + 2, &count));
    CHECK(count == LAYERS);
    for (uint32_t i = 0; i < LAYERS; i++) {
        CHECK(hits[i].prim_id == i && hits[i].t == 20.0f + (float)i);
    }
    OK(hd_nearest_hits(tree, &ray, hits, 2, &count));
    CHECK(count == 2 && hits[1].prim_id == 1);

    OK(hd_scene_nearest_hits(scene, &scene_ray, NULL, 0, &count));
    CHECK(count == 2 * LAYERS);
    OK(hd_scene_nearest_hits(scene, &scene_ray, scene_hits, 2 * LAYERS, &count));
    CHECK(count == 2 * LAYERS);
    for (uint32_t i = 0; i < 2 * LAYERS; i++) {
        CHECK(scene_hits[i].item == (i < LAYERS ? 1u : 0u) && scene_hits[i].hit.prim_id == i % LAYERS);
    }
    scene_ray.mask = 4;
    OK(hd_scene_nearest_hits(scene, &scene_ray, NULL, 0, &count));
    CHECK(count == LAYERS);
    FAILS(HD_ERROR_NULL, "hits is NULL", hd_nearest_hits(tree, &ray, NULL, 1, &count));
    FAILS(HD_ERROR_NULL, "count is NULL", hd_nearest_hits(tree, &ray, hits, 1, NULL));
    hd_scene_free(scene);
    hd_tree_free(tree);
}

static void closest_points(void) {
    hd_tree *tree = tree_of_layers();
    hd_scene *scene = two_of(tree);
    const float point[3] = {0.25f, 0.25f, 2.0f}, beside[3] = {-3.0f, 0.0f, -6.0f}, nan[3] = {0, NAN, 0};
    float closest[3];
    hd_hit hit;
    hd_scene_hit scene_hit;
    OK(hd_closest_point(tree, point, INFINITY, closest, &hit));
    CHECK(hit.prim_id == 0 && hit.t == 2 && closest[0] == 0.25f && closest[1] == 0.25f && closest[2] == 0);
    OK(hd_closest_point(tree, beside, 10, closest, &hit));
    CHECK(hit.prim_id == 5 && fabsf(hit.t - sqrtf(10)) < 1e-6f && closest[0] == 0 && closest[1] == 0 && closest[2] == -5);
    OK(hd_closest_point(tree, point, 1.5f, closest, &hit));
    CHECK(hit.prim_id == HD_NO_PRIM && closest[0] == 0 && closest[1] == 0 && closest[2] == 0);
    OK(hd_closest_point(tree, point, 5, NULL, &hit));
    CHECK(hit.prim_id == 0);

    /* The upper layers end at z = 5. */
    OK(hd_scene_closest_point(scene, point, INFINITY, 0, 0, closest, &scene_hit));
    CHECK(scene_hit.item == 0 && scene_hit.hit.t == 2 && closest[2] == 0);
    OK(hd_scene_closest_point(scene, point, INFINITY, 0, 2, closest, &scene_hit));
    CHECK(scene_hit.item == 0 && scene_hit.hit.prim_id == 0);
    const float high[3] = {0.25f, 0.25f, 4.0f};
    OK(hd_scene_closest_point(scene, high, INFINITY, 0, 0, closest, &scene_hit));
    CHECK(scene_hit.item == 1 && scene_hit.hit.prim_id == 5 && scene_hit.hit.t == 1 && closest[2] == 5);
    OK(hd_scene_closest_point(scene, high, INFINITY, 0, 1, closest, &scene_hit));
    CHECK(scene_hit.item == 0 && scene_hit.hit.t == 4);

    FAILS(HD_ERROR_VALUE, "point has a NaN", hd_closest_point(tree, nan, 1, closest, &hit));
    FAILS(HD_ERROR_VALUE, "radius is -1", hd_closest_point(tree, point, -1, closest, &hit));
    FAILS(HD_ERROR_VALUE, "radius is NaN", hd_scene_closest_point(scene, point, NAN, 0, 0, closest, &scene_hit));
    FAILS(HD_ERROR_VALUE, "time is NaN", hd_scene_closest_point(scene, point, 1, NAN, 0, closest, &scene_hit));
    FAILS(HD_ERROR_NULL, "point is NULL", hd_closest_point(tree, NULL, 1, closest, &hit));
    FAILS(HD_ERROR_NULL, "hit is NULL", hd_closest_point(tree, point, 1, closest, NULL));
    hd_scene_free(scene);
    hd_tree_free(tree);
}

static void overlaps(void) {
    hd_tree *tree = tree_of_layers();
    hd_scene *scene = two_of(tree);
    const float min[3] = {0.1f, 0.1f, -3.5f}, max[3] = {0.2f, 0.2f, -1.5f}, nan[3] = {NAN, 0, 0}, top[3] = {1, 1, 8};
    uint32_t numbers[LAYERS] = {9, 9, 9, 9, 9, 9};
    hd_scene_hit hits[2 * LAYERS];
    size_t count;
    OK(hd_overlaps(tree, min, max, numbers, LAYERS, &count));
    CHECK(count == 2 && numbers[0] + numbers[1] == 5 && (numbers[0] == 2 || numbers[0] == 3));
    /* Counted, whether there is room or not. */
    OK(hd_overlaps(tree, min, top, numbers, 1, &count));
    CHECK(count == 4);
    OK(hd_overlaps(tree, min, max, NULL, 0, &count));
    CHECK(count == 2);
    OK(hd_overlaps(tree, max, min, NULL, 0, &count));
    CHECK(count == 0);
    OK(hd_scene_overlaps(scene, min, top, 0, 0, hits, 2 * LAYERS, &count));
    /* z from -3.5 to 8: layers 0 to 3 of the lower, 2 to 5 of the higher. */
    CHECK(count == 8);
    int lower = 0;
    for (size_t i = 0; i < count; i++) {
        lower += hits[i].item == 0;
        CHECK(hits[i].hit.t == 0);
    }
    CHECK(lower == 4);
    OK(hd_scene_overlaps(scene, min, top, 0, 1, hits, 2, &count));
    CHECK(count == 4);
    FAILS(HD_ERROR_VALUE, "min has a NaN", hd_overlaps(tree, nan, max, numbers, LAYERS, &count));
    FAILS(HD_ERROR_NULL, "max is NULL", hd_overlaps(tree, min, NULL, numbers, LAYERS, &count));
    FAILS(HD_ERROR_NULL, "prim_ids is NULL", hd_overlaps(tree, min, max, NULL, LAYERS, &count));
    FAILS(HD_ERROR_NULL, "count is NULL", hd_overlaps(tree, min, max, numbers, LAYERS, NULL));
    FAILS(HD_ERROR_VALUE, "time is NaN", hd_scene_overlaps(scene, min, max, NAN, 0, hits, 1, &count));
    hd_scene_free(scene);
    hd_tree_free(tree);
}

static void refits(void) {
    float corners[LAYERS][3][3];
    hd_tree *tree = tree_of_layers(), *opened = NULL;
    hd_scene *scene = two_of(tree);
    size_t size;
    OK(hd_tree_save(tree, NULL, 0, &size));
    unsigned char *memory = (unsigned char *)malloc(size + HD_BLOB_ALIGNMENT);
    unsigned char *blob = memory + (HD_BLOB_ALIGNMENT - (uintptr_t)memory % HD_BLOB_ALIGNMENT) % HD_BLOB_ALIGNMENT;
    OK(hd_tree_save(tree, blob, size, &size));
    OK(hd_tree_open(blob, size, &opened));

    place(corners, 7);
    const hd_mesh moved = layers(corners);
    const hd_ray here = ray_of(0.25f, 0.25f, 1.0f, 0, 0, -1), there = ray_of(7.25f, 0.25f, 1.0f, 0, 0, -1);
    hd_hit hit;
    for (int i = 0; i < 2; i++) {
        hd_tree *refitted = i ? opened : tree;
        float decay = 0;
        OK(hd_tree_refit(refitted, &moved, &decay));
        CHECK(decay > 0.99f && decay < 1.01f);
        OK(hd_intersect(refitted, &there, &hit));
        CHECK(hit.prim_id == 0 && hit.t == 1);
        OK(hd_intersect(refitted, &here, &hit));
        CHECK(hit.prim_id == HD_NO_PRIM);
        float triangle[9];
        OK(hd_tree_triangle(refitted, 4, triangle));
        CHECK(memcmp(triangle, corners[4], sizeof triangle) == 0);
        FAILS(HD_ERROR_VALUE, "no triangle 6", hd_tree_triangle(refitted, LAYERS, triangle));
    }
    /* The scene has the tree as it was, until it gets it anew. */
    hd_scene_ray ray;
    hd_scene_hit scene_hit;
    memset(&ray, 0, sizeof ray);
    ray.ray = here;
    OK(hd_scene_intersect(scene, &ray, &scene_hit));
    CHECK(scene_hit.item == 0 && scene_hit.hit.t == 1);
    hd_item item;
    hd_handle handle;
    memset(&item, 0, sizeof item);
    item.struct_size = sizeof item;
    item.tree = tree;
    OK(hd_scene_handle(scene, 0, &handle));
    OK(hd_scene_set_item(scene, handle, &item));
    OK(hd_scene_commit(scene, NULL));
    OK(hd_scene_intersect(scene, &ray, &scene_hit));
    CHECK(scene_hit.hit.prim_id == HD_NO_PRIM);
    ray.ray = there;
    OK(hd_scene_intersect(scene, &ray, &scene_hit));
    CHECK(scene_hit.item == 0 && scene_hit.hit.t == 1);

    /* What cannot be followed leaves the tree as it was. */
    hd_mesh fewer = moved;
    fewer.index_count -= 3;
    FAILS(HD_ERROR_VALUE, "only 5", hd_tree_refit(tree, &fewer, NULL));
    memcpy(corners[2][1], corners[2][0], sizeof corners[2][0]);
    FAILS(HD_ERROR_VALUE, "two equal corners", hd_tree_refit(tree, &moved, NULL));
    corners[2][1][0] = NAN;
    FAILS(HD_ERROR_VALUE, "triangle 2 has the corner", hd_tree_refit(tree, &moved, NULL));
    OK(hd_intersect(tree, &there, &hit));
    CHECK(hit.prim_id == 0 && hit.t == 1);
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_tree_refit(NULL, &moved, NULL));
    FAILS(HD_ERROR_NULL, "mesh is NULL", hd_tree_refit(tree, NULL, NULL));
    FAILS(HD_ERROR_NULL, "corners is NULL", hd_tree_triangle(tree, 0, NULL));
    hd_tree_free(opened);
    hd_tree_free(tree);
    hd_scene_free(scene);
    free(memory);
}

int main(void) {
    filters();
    all_hits();
    closest_points();
    overlaps();
    refits();
    puts("queries: passed");
    return 0;
}
