/* Trees of triangles that move between keys, in scenes; scenes as bytes; items of older headers. */
#include <stddef.h>

#include "check.h"

/* A triangle that falls from z = 4 to z = 0, with corners at x and y of 0 and 1. */
static hd_moving_tree *falling(void) {
    static const float above[] = {0, 0, 4, 1, 0, 4, 0, 1, 4};
    static const float below[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    const hd_mesh keys[2] = {mesh_of(above, 3, NULL, 0), mesh_of(below, 3, NULL, 0)};
    hd_moving_tree *tree = NULL;
    OK(hd_moving_tree_build(keys, 2, NULL, &tree));
    return tree;
}

static hd_item item_with(const hd_moving_tree *moving, const hd_tree *tree, const hd_scene *scene) {
    hd_item item = empty_item();
    item.moving = moving;
    item.tree = tree;
    item.scene = scene;
    return item;
}

/* The distance down from z = 8 at (x, 0.25), infinite if there is nothing. */
static float down(const hd_scene *scene, float x, float time, uint32_t *item) {
    hd_scene_ray ray;
    hd_scene_hit hit, same;
    bool occluded = false;
    ray.ray = ray_of(x, 0.25f, 8.0f, 0.0f, 0.0f, -1.0f);
    ray.time = time;
    ray.mask = 0;
    OK(hd_scene_intersect(scene, &ray, &hit));
    OK(hd_scene_intersect_many(scene, &ray, &same, 1));
    OK(hd_scene_occluded(scene, &ray, &occluded));
    CHECK(memcmp(&hit, &same, sizeof hit) == 0 && occluded == (hit.hit.prim_id != HD_NO_PRIM));
    *item = hit.item;
    return hit.hit.t;
}

static void check_scene(const hd_scene *scene) {
    uint32_t item;
    CHECK(down(scene, 0.25f, 0.0f, &item) == 4.0f && item == 0);
    CHECK(down(scene, 0.25f, 0.5f, &item) == 6.0f && item == 0);
    CHECK(down(scene, 0.25f, 1.0f, &item) == 8.0f && item == 0);
    /* The floor, four squares to the right. */
    CHECK(down(scene, 4.75f, 0.5f, &item) == 8.0f && item == 1);
    /* The scene in it, at 30, has the falling triangle alone. */
    CHECK(down(scene, 30.25f, 0.5f, &item) == 6.0f && item == 0);
    CHECK(isinf(down(scene, 31.25f, 0.5f, &item)));
}

static hd_scene *moving_scene(void) {
    static const float right[12] = {1, 0, 0, 4, 0, 1, 0, 0, 0, 0, 1, 0};
    static const float far_right[12] = {1, 0, 0, 30, 0, 1, 0, 0, 0, 0, 1, 0};
    hd_moving_tree *moving = falling();
    hd_tree *floor = floor_tree(HD_QUALITY_HIGH);
    hd_scene *inner = NULL, *scene = NULL;
    const hd_item only = item_with(moving, NULL, NULL);
    OK(hd_scene_build(&only, 1, NULL, &inner));
    hd_item items[3] = {only, item_with(NULL, floor, NULL), item_with(NULL, NULL, inner)};
    items[1].transforms = right;
    items[2].transforms = far_right;
    items[1].transform_count = items[2].transform_count = 1;
    OK(hd_scene_build(items, 3, NULL, &scene));
    /* The scene shares what is in it. */
    hd_moving_tree_free(moving);
    hd_tree_free(floor);
    hd_scene_free(inner);
    return scene;
}

static void bad_keys(void) {
    static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0};
    const hd_mesh one = mesh_of(corners, 3, NULL, 0), two = mesh_of(corners, 6, NULL, 0);
    hd_mesh keys[2] = {one, two};
    hd_moving_tree *tree = NULL;
    FAILS(HD_ERROR_VALUE, "keys", hd_moving_tree_build(keys, 2, NULL, &tree));
    CHECK(tree == NULL);
    FAILS(HD_ERROR_VALUE, "keys", hd_moving_tree_build(keys, 0, NULL, &tree));
    FAILS(HD_ERROR_VALUE, "keys", hd_moving_tree_build(NULL, 0, NULL, &tree));
    FAILS(HD_ERROR_NULL, "keys is NULL", hd_moving_tree_build(NULL, 2, NULL, &tree));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_moving_tree_build(keys, 1, NULL, NULL));
    keys[1] = one;
    keys[1].vertex_count = 2;
    FAILS(HD_ERROR_SIZE, "key 1: mesh->vertex_count is 2", hd_moving_tree_build(keys, 2, NULL, &tree));
    /* Meshes as programs have them that were compiled before there were indices of 16 bits: an array of shorter structures. */
    const size_t before = offsetof(hd_mesh, index_size);
    unsigned char *old = (unsigned char *)malloc(2 * before);
    for (int i = 0; i < 2; i++) {
        keys[0] = one;
        keys[0].struct_size = before;
        memcpy(old + i * before, &keys[0], before);
    }
    OK(hd_moving_tree_build((const hd_mesh *)(const void *)old, 2, NULL, &tree));
    hd_moving_tree_free(tree);
    free(old);
    keys[0] = keys[1] = one;
    keys[1].struct_size = 7;
    FAILS(HD_ERROR_VERSION, "keys[1]->struct_size is 7", hd_moving_tree_build(keys, 2, NULL, &tree));
    hd_moving_tree_free(NULL);
}

static void items_are_one_thing(void) {
    hd_moving_tree *moving = falling();
    hd_tree *floor = floor_tree(HD_QUALITY_FAST);
    hd_scene *scene = NULL;
    hd_item item = item_with(moving, floor, NULL);
    FAILS(HD_ERROR_VALUE, "item 0: it has more than one of", hd_scene_build(&item, 1, NULL, &scene));
    /* As programs have them that were compiled before there were trees that move: an array of shorter structures. */
    const size_t before = offsetof(hd_item, moving);
    unsigned char *old = (unsigned char *)malloc(2 * before);
    for (int i = 0; i < 2; i++) {
        item = item_with(NULL, floor, NULL);
        item.struct_size = before;
        item.mask = i == 0 ? 1 : 2;
        memcpy(old + i * before, &item, before);
    }
    OK(hd_scene_build((const hd_item *)(const void *)old, 2, NULL, &scene));
    uint32_t number;
    CHECK(down(scene, 0.75f, 0.0f, &number) == 8.0f && number == 0);
    hd_scene_free(scene);
    free(old);
    hd_tree_free(floor);
    hd_moving_tree_free(moving);
}

static void scenes_as_bytes(void) {
    hd_scene *scene = moving_scene(), *loaded = NULL;
    size_t size = 0, again = 0;
    OK(hd_scene_save(scene, NULL, 0, &size));
    unsigned char *blob = (unsigned char *)malloc(size + 1);
    FAILS(HD_ERROR_SIZE, "capacity", hd_scene_save(scene, blob, size - 1, &again));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_save(NULL, blob, size, &again));
    FAILS(HD_ERROR_NULL, "size is NULL", hd_scene_save(scene, blob, size, NULL));
    OK(hd_scene_save(scene, blob + 1, size, &again));
    CHECK(again == size);
    /* From any address, and after what it was saved from is gone. */
    hd_scene_free(scene);
    OK(hd_scene_load(blob + 1, size, &loaded));
    check_scene(loaded);
    /* Where it lies, if that is where trees can be traced. */
    unsigned char *memory = (unsigned char *)malloc(size + HD_BLOB_ALIGNMENT);
    unsigned char *aligned = memory + (HD_BLOB_ALIGNMENT - (size_t)memory % HD_BLOB_ALIGNMENT);
    hd_scene *opened = NULL;
    memcpy(aligned, blob + 1, size);
    OK(hd_scene_open(aligned, size, &opened));
    check_scene(opened);
    hd_scene_free(opened);
    FAILS(HD_ERROR_NULL, "bytes is NULL", hd_scene_open(NULL, size, &opened));
    CHECK(hd_scene_open(aligned, size - 1, &opened) == HD_ERROR_BLOB && opened == NULL);
    memmove(aligned - 1, aligned, size);
    FAILS(HD_ERROR_ALIGNMENT, "64", hd_scene_open(aligned - 1, size, &opened));
    free(memory);
    /* Its items have handles. */
    const hd_handle floor = {1, 0};
    hd_commit commit;
    memset(&commit, 0, sizeof commit);
    commit.struct_size = sizeof commit;
    uint32_t number;
    OK(hd_scene_remove(loaded, floor));
    OK(hd_scene_commit(loaded, &commit));
    CHECK(commit.seen == 2 && isinf(down(loaded, 4.75f, 0.5f, &number)));
    hd_scene_free(loaded);

    FAILS(HD_ERROR_NULL, "bytes is NULL", hd_scene_load(NULL, size, &loaded));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_load(blob + 1, size, NULL));
    for (size_t length = 0; length < size; length += length < 200 ? 1 : 9973) {
        CHECK(hd_scene_load(blob + 1, length, &loaded) == HD_ERROR_BLOB && loaded == NULL);
    }
    for (size_t at = 1; at <= size; at += at < 200 ? 1 : 9973) {
        blob[at] ^= 0x10;
        CHECK(hd_scene_load(blob + 1, size, &loaded) != HD_OK && loaded == NULL);
        blob[at] ^= 0x10;
    }
    /* A tree is no scene. */
    hd_tree *tree = floor_tree(HD_QUALITY_HIGH);
    OK(hd_tree_save(tree, NULL, 0, &size));
    blob = (unsigned char *)realloc(blob, size);
    OK(hd_tree_save(tree, blob, size, &size));
    FAILS(HD_ERROR_BLOB, "scene", hd_scene_load(blob, size, &loaded));
    hd_tree_free(tree);
    free(blob);
}

int main(void) {
    hd_scene *scene = moving_scene();
    check_scene(scene);
    hd_scene_free(scene);
    bad_keys();
    items_are_one_thing();
    scenes_as_bytes();
    puts("keys: passed");
    return 0;
}
