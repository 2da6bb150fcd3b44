/* Trees of points and curves, in scenes and in their blobs; the surface at a hit. */
#include "check.h"

static hd_round_tree *round_tree(uint32_t kind, const float *numbers, size_t count) {
    hd_round_tree *tree = NULL;
    OK(hd_round_tree_build(kind, numbers, count, NULL, &tree));
    return tree;
}

static hd_item item_of(const hd_round_tree *round, const float *transform) {
    hd_item item = empty_item();
    item.round = round;
    item.transforms = transform;
    item.transform_count = transform != NULL;
    return item;
}

/* What a ray down from z = 8 at (x, y) meets. */
static hd_scene_hit down(const hd_scene *scene, float x, float y) {
    hd_scene_ray ray;
    hd_scene_hit hit, same;
    memset(&ray, 0, sizeof ray);
    ray.ray = ray_of(x, y, 8.0f, 0.0f, 0.0f, -1.0f);
    OK(hd_scene_intersect(scene, &ray, &hit));
    OK(hd_scene_intersect_many(scene, &ray, &same, 1));
    CHECK(memcmp(&hit, &same, sizeof hit) == 0);
    return hit;
}

static const float spheres[] = {0, 0, 0, 1, /**/ 5, 0, 0, 0, /**/ 10, 0, 0, 2};
static const float disc[] = {20, 0, 1, 2, 0, 0, 3};
static const float segment[] = {30, 0, 0, 1, 30, 4, 0, 1};
static const float curve[] = {40, 0, 0, 1, 40, 1, 0, 1, 40, 2, 0, 1, 40, 3, 0, 1};
static const float raised[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 3};

static void check_scene(const hd_scene *scene) {
    hd_scene_hit hit = down(scene, 0.0f, 0.0f);
    CHECK(hit.hit.t == 7.0f && hit.item == 0 && hit.hit.prim_id == 0);
    /* The sphere without a radius is not there, and the others keep their numbers. */
    CHECK(down(scene, 5.0f, 0.0f).hit.prim_id == HD_NO_PRIM);
    hit = down(scene, 10.0f, 0.0f);
    CHECK(hit.hit.t == 6.0f && hit.item == 0 && hit.hit.prim_id == 2);
    /* Half of a radius from the centre, and raised by 3. */
    hit = down(scene, 20.0f, 1.0f);
    CHECK(hit.hit.t == 4.0f && hit.item == 1 && hit.hit.u == 0.5f && hit.hit.v == 0.0f);
    hit = down(scene, 30.0f, 1.0f);
    CHECK(hit.hit.t == 7.0f && hit.item == 2 && hit.hit.u == 0.25f);
    hit = down(scene, 40.0f, 1.5f);
    CHECK(fabsf(hit.hit.t - 7.0f) < 0.005f && hit.item == 3 && fabsf(hit.hit.u - 0.5f) < 0.01f);
}

static hd_scene *scene_of_all(void) {
    hd_round_tree *trees[4] = {round_tree(HD_SPHERES, spheres, 3), round_tree(HD_DISCS, disc, 1),
                               round_tree(HD_LINEAR_CURVES, segment, 1), round_tree(HD_CUBIC_CURVES, curve, 1)};
    hd_item items[4];
    hd_scene *scene = NULL;
    for (int i = 0; i < 4; i++) items[i] = item_of(trees[i], i == 1 ? raised : NULL);
    OK(hd_scene_build(items, 4, NULL, &scene));
    /* The scene shares what is in it. */
    for (int i = 0; i < 4; i++) hd_round_tree_free(trees[i]);
    return scene;
}

static void scenes_and_blobs(void) {
    hd_scene *scene = scene_of_all(), *loaded = NULL;
    check_scene(scene);
    size_t size = 0;
    OK(hd_scene_save(scene, NULL, 0, &size));
    unsigned char *blob = (unsigned char *)malloc(size);
    OK(hd_scene_save(scene, blob, size, &size));
    hd_scene_free(scene);
    OK(hd_scene_load(blob, size, &loaded));
    free(blob);
    check_scene(loaded);
    hd_scene_free(loaded);
}

static void surfaces(void) {
    hd_round_surface surface;
    hd_ray ray = ray_of(0.0f, 0.0f, 8.0f, 0.0f, 0.0f, -1.0f);
    OK(hd_round_surface_at(HD_SPHERES, spheres, &ray, &surface));
    CHECK(surface.point[2] == 1.0f && surface.normal[2] == 1.0f && surface.shading_normal[2] == 1.0f);
    CHECK(surface.is_front == 1 && surface.offset > 0.0f && surface.offset < 1e-4f);
    /* From within, and from below a disc. */
    ray = ray_of(0.0f, 0.0f, 0.0f, 0.0f, 0.0f, -1.0f);
    OK(hd_round_surface_at(HD_SPHERES, spheres, &ray, &surface));
    CHECK(surface.point[2] == -1.0f && surface.normal[2] == 1.0f && surface.is_front == 0);
    ray = ray_of(20.0f, 0.0f, 0.0f, 0.0f, 0.0f, 1.0f);
    OK(hd_round_surface_at(HD_DISCS, disc, &ray, &surface));
    CHECK(surface.point[2] == 1.0f && surface.normal[2] == -1.0f && surface.is_front == 0);
    ray = ray_of(0.0f, 3.0f, 8.0f, 0.0f, 0.0f, -1.0f);
    FAILS(HD_ERROR_VALUE, "ray does not hit it", hd_round_surface_at(HD_SPHERES, spheres, &ray, &surface));
    FAILS(HD_ERROR_VALUE, "kind is 4", hd_round_surface_at(4, spheres, &ray, &surface));
    FAILS(HD_ERROR_NULL, "numbers is NULL", hd_round_surface_at(HD_SPHERES, NULL, &ray, &surface));
    FAILS(HD_ERROR_NULL, "ray is NULL", hd_round_surface_at(HD_SPHERES, spheres, NULL, &surface));
    FAILS(HD_ERROR_NULL, "surface is NULL", hd_round_surface_at(HD_SPHERES, spheres, &ray, NULL));
}

static void bad_arguments(void) {
    hd_round_tree *tree = NULL;
    FAILS(HD_ERROR_VALUE, "kind is 9", hd_round_tree_build(9, spheres, 3, NULL, &tree));
    CHECK(tree == NULL);
    FAILS(HD_ERROR_NULL, "numbers is NULL", hd_round_tree_build(HD_SPHERES, NULL, 3, NULL, &tree));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_round_tree_build(HD_SPHERES, spheres, 3, NULL, NULL));
    FAILS(HD_ERROR_SIZE, "no such memory", hd_round_tree_build(HD_CUBIC_CURVES, spheres, SIZE_MAX / 16, NULL, &tree));
    /* None at all, and numbers that are none: trees that no ray hits. */
    const float nothing[] = {NAN, 0, 0, 1};
    OK(hd_round_tree_build(HD_SPHERES, NULL, 0, NULL, &tree));
    hd_round_tree_free(tree);
    tree = round_tree(HD_SPHERES, nothing, 1);
    hd_item item = item_of(tree, NULL);
    hd_scene *scene = NULL;
    OK(hd_scene_build(&item, 1, NULL, &scene));
    CHECK(down(scene, 0.0f, 0.0f).hit.prim_id == HD_NO_PRIM);
    hd_scene_free(scene);
    hd_tree *floor = floor_tree(HD_QUALITY_FAST);
    item.tree = floor;
    FAILS(HD_ERROR_VALUE, "item 0: it has more than one of tree, scene, moving and round",
          hd_scene_build(&item, 1, NULL, &scene));
    hd_tree_free(floor);
    hd_round_tree_free(tree);
    hd_round_tree_free(NULL);
}

int main(void) {
    scenes_and_blobs();
    surfaces();
    bad_arguments();
    puts("points and curves: as they should be");
    return 0;
}
