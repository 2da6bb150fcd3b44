/* Scenes: instances, masks, motion and nesting with known answers, and what becomes of bad input. */
#include "check.h"

/* The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0). */
static hd_tree *triangle_tree(void) {
    static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    hd_mesh mesh = mesh_of(corners, 3, NULL, 0);
    hd_tree *tree = NULL;
    OK(hd_tree_build(&mesh, NULL, &tree));
    return tree;
}

static hd_item item_of(const hd_tree *tree, const hd_scene *scene, const float *transforms, size_t transform_count) {
    hd_item item = empty_item();
    item.tree = tree;
    item.scene = scene;
    item.transforms = transforms;
    item.transform_count = transform_count;
    return item;
}

static hd_scene_ray ray_at(float x, float y, float time, uint32_t mask) {
    hd_scene_ray ray;
    ray.ray = ray_of(x, y, 8.0f, 0.0f, 0.0f, -1.0f);
    ray.time = time;
    ray.mask = mask;
    return ray;
}

/* No number of an item. */
#define NO_INSTANCE 0xFFFFFFFFu

/* The ray straight down at (x, y) hits at z = 8 - t, or nothing at t = 0. */
static void expect(const hd_scene *scene, hd_scene_ray ray, float t, uint32_t item, uint32_t instance) {
    hd_scene_hit hit;
    bool occluded;
    uint32_t found = NO_INSTANCE;
    OK(hd_scene_intersect(scene, &ray, &hit));
    OK(hd_scene_occluded(scene, &ray, &occluded));
    CHECK(occluded == (t != 0.0f) && (hit.hit.prim_id == HD_NO_PRIM) == (t == 0.0f));
    if (t != 0.0f) {
        CHECK(hit.hit.t == t && hit.hit.prim_id == 0 && hit.item == item);
        CHECK(hit.depth == (instance == NO_INSTANCE ? 0 : 1));
        OK(hd_scene_instances(scene, &hit, &found, 1));
        CHECK(found == instance);
    }
}

#define ALL 0xFFFFFFFFu

/* One to the right, twice as large and higher; and one that moves from y = 0 to y = 4. */
static const float larger[12] = {2, 0, 0, 4, 0, 2, 0, 0, 0, 0, 2, 3};
static const float moving[24] = {1, 0, 0, -4, 0, 1, 0, 0, 0, 0, 1, 0, 1, 0, 0, -4, 0, 1, 0, 4, 0, 0, 1, 0};

static hd_scene *three_items(const hd_tree *tree) {
    hd_item items[3] = {item_of(tree, NULL, NULL, 0), item_of(tree, NULL, larger, 1), item_of(tree, NULL, moving, 2)};
    items[1].mask = 2;
    hd_scene *scene = NULL;
    OK(hd_scene_build(items, 3, NULL, &scene));
    return scene;
}

static void check_three(const hd_scene *scene) {
    expect(scene, ray_at(0.25f, 0.25f, 0, ALL), 8, 0, NO_INSTANCE);
    expect(scene, ray_at(0.75f, 0.75f, 0, ALL), 0, 0, 0);
    expect(scene, ray_at(5.0f, 0.5f, 0, ALL), 5, 1, NO_INSTANCE);
    expect(scene, ray_at(5.0f, 0.5f, 0, 2), 5, 1, NO_INSTANCE);
    expect(scene, ray_at(5.0f, 0.5f, 0, 5), 0, 0, 0);
    /* A zeroed mask sees all. */
    expect(scene, ray_at(5.0f, 0.5f, 0, 0), 5, 1, NO_INSTANCE);
    expect(scene, ray_at(-3.75f, 0.25f, 0, ALL), 8, 2, NO_INSTANCE);
    expect(scene, ray_at(-3.75f, 0.25f, 0.5f, ALL), 0, 0, 0);
    expect(scene, ray_at(-3.75f, 2.25f, 0.5f, ALL), 8, 2, NO_INSTANCE);
    expect(scene, ray_at(-3.75f, 4.25f, 7.0f, ALL), 8, 2, NO_INSTANCE);
}

/* Masks of 0 among others, in more rays than are looked at together. */
static void zeroed_masks(void) {
    enum { COUNT = 150 };
    static hd_scene_ray rays[COUNT];
    static hd_scene_hit hits[COUNT];
    static bool occluded[COUNT];
    hd_tree *tree = triangle_tree();
    hd_scene *scene = three_items(tree);
    for (int i = 0; i < COUNT; ++i) rays[i] = ray_at(5.0f, 0.5f, 0, i % 3 == 0 ? 0 : i % 3 == 1 ? 2 : 5);
    OK(hd_scene_intersect_many(scene, rays, hits, COUNT));
    OK(hd_scene_occluded_many(scene, rays, occluded, COUNT));
    for (int i = 0; i < COUNT; ++i) {
        CHECK(occluded[i] == (i % 3 != 2) && (hits[i].hit.prim_id == 0) == occluded[i]);
        CHECK(rays[i].mask == (i % 3 == 0 ? 0u : i % 3 == 1 ? 2u : 5u));
    }
    hd_scene_free(scene);
    hd_tree_free(tree);
}

static void known_hits(void) {
    hd_tree *tree = triangle_tree();
    hd_scene *scene = three_items(tree);
    check_three(scene);

    /* Scenes in a scene, ten up and as they are. What they are made of can be freed. */
    static const float up[12] = {1, 0, 0, 0, 0, 1, 0, 10, 0, 0, 1, 0};
    const hd_item items[2] = {item_of(NULL, scene, up, 1), item_of(NULL, scene, NULL, 0)};
    hd_scene *outer = NULL;
    OK(hd_scene_build(items, 2, NULL, &outer));
    hd_tree_free(tree);
    check_three(scene);
    hd_scene_free(scene);
    expect(outer, ray_at(5.0f, 10.5f, 0, ALL), 5, 1, 0);
    expect(outer, ray_at(5.0f, 0.5f, 0, ALL), 5, 1, 1);
    expect(outer, ray_at(-3.75f, 12.25f, 0.5f, ALL), 8, 2, 0);

    enum { COUNT = 200 };
    static hd_scene_ray rays[COUNT];
    static hd_scene_hit hits[COUNT];
    static bool occluded[COUNT];
    int found = 0;
    for (int i = 0; i < COUNT; i++) {
        rays[i] = ray_at((float)(i % 20) * 0.6f - 5.0f, (float)(i / 20) * 0.9f, (float)(i % 5) / 4.0f, ALL);
    }
    OK(hd_scene_intersect_many(outer, rays, hits, COUNT));
    OK(hd_scene_occluded_many(outer, rays, occluded, COUNT));
    for (int i = 0; i < COUNT; i++) {
        hd_scene_hit hit;
        OK(hd_scene_intersect(outer, &rays[i], &hit));
        CHECK(memcmp(&hit, &hits[i], sizeof hit) == 0 && occluded[i] == (hit.hit.prim_id != HD_NO_PRIM));
        found += occluded[i];
    }
    CHECK(found > 3 && found < COUNT);
    hd_scene_free(outer);
}

static void bad_scenes_are_refused(void) {
    hd_tree *tree = triangle_tree();
    hd_scene *good = three_items(tree), *scene = NULL;
    hd_item items[2] = {item_of(tree, NULL, NULL, 0), item_of(tree, NULL, NULL, 0)};
    FAILS(HD_ERROR_NULL, "items is NULL", hd_scene_build(NULL, 1, NULL, &scene));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_build(items, 2, NULL, NULL));
    FAILS(HD_ERROR_SIZE, "no such memory", hd_scene_build(items, SIZE_MAX, NULL, &scene));
    items[1].tree = NULL;
    FAILS(HD_ERROR_NULL, "item 1: it has none of", hd_scene_build(items, 2, NULL, &scene));
    items[1].tree = tree, items[1].scene = good;
    FAILS(HD_ERROR_VALUE, "item 1: it has more than one", hd_scene_build(items, 2, NULL, &scene));
    items[1] = item_of(tree, NULL, NULL, 1);
    FAILS(HD_ERROR_NULL, "item 1: its transforms is NULL", hd_scene_build(items, 2, NULL, &scene));
    items[1] = item_of(tree, NULL, larger, 1);
    items[1].transform_count = 0;
    FAILS(HD_ERROR_SIZE, "item 1: it has transforms", hd_scene_build(items, 2, NULL, &scene));
    items[1].transforms = larger, items[1].transform_count = SIZE_MAX;
    FAILS(HD_ERROR_SIZE, "item 1", hd_scene_build(items, 2, NULL, &scene));
    items[1] = item_of(tree, NULL, NULL, 0), items[1].struct_size = 8;
    FAILS(HD_ERROR_VERSION, "items[1]->struct_size", hd_scene_build(items, 2, NULL, &scene));

    float matrix[12];
    memcpy(matrix, larger, sizeof matrix);
    items[1] = item_of(tree, NULL, matrix, 1);
    matrix[5] = NAN;
    FAILS(HD_ERROR_VALUE, "item 1", hd_scene_build(items, 2, NULL, &scene));
    /* Nearly flat. */
    matrix[5] = 1e-5f;
    FAILS(HD_ERROR_VALUE, "item 1", hd_scene_build(items, 2, NULL, &scene));
    /* What is flat is hidden. */
    matrix[5] = 0.0f;
    OK(hd_scene_build(items, 2, NULL, &scene));
    expect(scene, ray_at(5.0f, 0.0f, 0, ALL), 0, 0, 0);
    hd_scene_free(scene);
    scene = NULL;

    /* Each scene has the one before it twice, until there are more ways through them than numbers. */
    hd_scene *level = three_items(tree);
    int depth = 0;
    for (hd_status status = HD_OK; status == HD_OK; depth++) {
        hd_item inner[2] = {item_of(NULL, level, NULL, 0), item_of(NULL, level, NULL, 0)};
        inner[1].mask = 2;
        status = hd_scene_build(inner, 2, NULL, &scene);
        CHECK(status == HD_OK || status == HD_ERROR_LIMIT);
        if (status == HD_OK) {
            hd_scene_free(level);
            level = scene;
        }
    }
    CHECK(scene == NULL && depth == 64);
    /* It sees but one of each two. */
    hd_scene_ray ray = ray_at(0.25f, 0.25f, 0, 1);
    hd_scene_hit hit;
    uint32_t way[64] = {0};
    OK(hd_scene_intersect(level, &ray, &hit));
    CHECK(hit.depth == 63);
    OK(hd_scene_instances(level, &hit, way, hit.depth));
    FAILS(HD_ERROR_SIZE, "room for 62", hd_scene_instances(level, &hit, way, 62));
    FAILS(HD_ERROR_NULL, "instances", hd_scene_instances(level, &hit, NULL, 64));
    FAILS(HD_ERROR_NULL, "hit", hd_scene_instances(level, NULL, way, 64));
    FAILS(HD_ERROR_NULL, "scene", hd_scene_instances(NULL, &hit, way, 64));
    hit.path = UINT64_MAX;
    FAILS(HD_ERROR_VALUE, "none of this scene", hd_scene_instances(level, &hit, way, 64));
    hd_scene_free(level);

    bool occluded;
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_intersect(NULL, &ray, &hit));
    FAILS(HD_ERROR_NULL, "ray is NULL", hd_scene_intersect(good, NULL, &hit));
    FAILS(HD_ERROR_NULL, "hit is NULL", hd_scene_intersect(good, &ray, NULL));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_occluded(NULL, &ray, &occluded));
    FAILS(HD_ERROR_NULL, "rays is NULL", hd_scene_intersect_many(good, NULL, &hit, 1));
    FAILS(HD_ERROR_NULL, "occluded is NULL", hd_scene_occluded_many(good, &ray, NULL, 1));
    ray.time = NAN;
    FAILS(HD_ERROR_VALUE, "ray 0 has a NaN", hd_scene_intersect(good, &ray, &hit));
    FAILS(HD_ERROR_VALUE, "ray 0 has a NaN", hd_scene_occluded(good, &ray, &occluded));

    /* A scene of nothing. */
    OK(hd_scene_build(NULL, 0, NULL, &scene));
    expect(scene, ray_at(0.25f, 0.25f, 0, ALL), 0, 0, 0);
    hd_scene_free(scene);
    check_three(good);
    hd_tree_free(tree);
    check_three(good);
    hd_scene_free(good);
    hd_scene_free(NULL);
}

int main(void) {
    known_hits();
    zeroed_masks();
    bad_scenes_are_refused();
    puts("scenes: passed");
    return 0;
}
