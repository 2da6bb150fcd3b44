/* Scenes that change: items come, move, hide and go, by handles that stay valid; what was not committed is not seen. */
#include "check.h"

/* The triangle (0, 0, 0), (1, 0, 0), (0, 1, 0). */
static hd_tree *triangle_tree(void) {
    static const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    hd_mesh mesh = mesh_of(corners, 3, NULL, 0);
    hd_tree *tree = NULL;
    OK(hd_tree_build(&mesh, NULL, &tree));
    return tree;
}

static hd_item item_of(const hd_tree *tree, const hd_scene *scene) {
    hd_item item = empty_item();
    item.tree = tree;
    item.scene = scene;
    return item;
}

static void at(float rows[12], float x) {
    const float moved[12] = {1, 0, 0, x, 0, 1, 0, 0, 0, 0, 1, 0};
    memcpy(rows, moved, sizeof moved);
}

/* The number of what is seen straight below (x + 0.25, 0.25) by a ray with this mask; NOTHING if nothing is. */
#define NOTHING 0xFFFFFFFFu

static uint32_t seen(const hd_scene *scene, float x, uint32_t mask) {
    hd_scene_ray ray;
    hd_scene_hit hit;
    memset(&ray, 0, sizeof ray);
    ray.ray = ray_of(x + 0.25f, 0.25f, 1.0f, 0, 0, -1);
    ray.mask = mask;
    OK(hd_scene_intersect(scene, &ray, &hit));
    return hit.hit.prim_id == HD_NO_PRIM ? NOTHING : hit.item;
}

static hd_commit commit(hd_scene *scene) {
    hd_commit done;
    memset(&done, 0, sizeof done);
    done.struct_size = sizeof done;
    OK(hd_scene_commit(scene, &done));
    return done;
}

static void items_come_and_go(void) {
    hd_tree *tree = triangle_tree();
    hd_scene *scene = NULL;
    OK(hd_scene_build(NULL, 0, NULL, &scene));
    const hd_item item = item_of(tree, NULL);
    hd_handle handles[20], found, other;
    float rows[12];
    for (int i = 0; i < 20; i++) {
        OK(hd_scene_insert(scene, &item, &handles[i]));
        at(rows, 2.0f * (float)i);
        OK(hd_scene_set_transform(scene, handles[i], rows));
    }
    hd_tree_free(tree);
    CHECK(seen(scene, 0, 0) == NOTHING);
    hd_commit done = commit(scene);
    CHECK(done.changed == 20 && done.seen == 20 && done.rebuilt == 1 && done.cost > 0);
    for (uint32_t i = 0; i < 20; i++) {
        CHECK(seen(scene, 2.0f * (float)i, 0) == i);
        OK(hd_scene_handle(scene, i, &found));
        CHECK(found.index == handles[i].index && found.generation == handles[i].generation);
    }

    /* Moved, hidden by mask and by a scale of nothing: each from the commit on. */
    at(rows, 100);
    OK(hd_scene_set_transform(scene, handles[3], rows));
    OK(hd_scene_set_mask(scene, handles[4], 2));
    memset(rows, 0, sizeof rows);
    OK(hd_scene_set_transform(scene, handles[5], rows));
    CHECK(seen(scene, 6, 0) == 3 && seen(scene, 8, 1) == 4 && seen(scene, 10, 0) == 5);
    done = commit(scene);
    CHECK(done.changed == 3 && done.seen == 19);
    CHECK(seen(scene, 6, 0) == NOTHING && seen(scene, 100, 0) == 3);
    CHECK(seen(scene, 8, 1) == NOTHING && seen(scene, 8, 2) == 4 && seen(scene, 8, 0) == 4 && seen(scene, 10, 0) == NOTHING);
    done = commit(scene);
    CHECK(done.changed == 0);

    /* Removed: the handle at once, the item from the commit on. Its number is used again, its handle is not. */
    OK(hd_scene_remove(scene, handles[7]));
    FAILS(HD_ERROR_VALUE, "no item 7 of generation 0", hd_scene_remove(scene, handles[7]));
    FAILS(HD_ERROR_VALUE, "no item 7", hd_scene_handle(scene, 7, &found));
    CHECK(seen(scene, 14, 0) == 7);
    commit(scene);
    CHECK(seen(scene, 14, 0) == NOTHING);
    const hd_tree *const gone = NULL;
    hd_item again = item_of(gone, NULL);
    FAILS(HD_ERROR_NULL, "none of", hd_scene_insert(scene, &again, &other));
    tree = triangle_tree();
    again.tree = tree;
    OK(hd_scene_insert(scene, &again, &other));
    CHECK(other.index == 7 && other.generation == 1);
    FAILS(HD_ERROR_VALUE, "generation 0", hd_scene_set_mask(scene, handles[7], 1));
    const hd_handle none = {4000, 0};
    FAILS(HD_ERROR_VALUE, "no item 4000", hd_scene_set_item(scene, none, &again));

    /* Bad transforms leave an item where it was. */
    at(rows, NAN);
    FAILS(HD_ERROR_VALUE, "transform 0", hd_scene_set_transform(scene, handles[0], rows));
    at(rows, 0);
    rows[5] = 1e-5f;
    FAILS(HD_ERROR_VALUE, "transform 0", hd_scene_set_transform(scene, handles[0], rows));
    commit(scene);
    CHECK(seen(scene, 0, 0) == 0 || seen(scene, 0, 0) == 7);

    FAILS(HD_ERROR_NULL, "rows is NULL", hd_scene_set_transform(scene, handles[0], NULL));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_set_transform(NULL, handles[0], rows));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_insert(NULL, &item, &other));
    FAILS(HD_ERROR_NULL, "item is NULL", hd_scene_insert(scene, NULL, &other));
    FAILS(HD_ERROR_NULL, "handle is NULL", hd_scene_insert(scene, &again, NULL));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_remove(NULL, handles[0]));
    FAILS(HD_ERROR_NULL, "scene is NULL", hd_scene_commit(NULL, NULL));
    FAILS(HD_ERROR_NULL, "handle is NULL", hd_scene_handle(scene, 0, NULL));
    done.struct_size = 4;
    FAILS(HD_ERROR_VERSION, "hd_commit", hd_scene_commit(scene, &done));
    hd_tree_free(tree);
    hd_scene_free(scene);
}

static void scenes_in_scenes_stay_as_they_were(void) {
    hd_tree *tree = triangle_tree();
    const hd_item item = item_of(tree, NULL);
    hd_scene *inner = NULL, *outer = NULL;
    OK(hd_scene_build(&item, 1, NULL, &inner));
    hd_item nested = item_of(NULL, inner);
    OK(hd_scene_build(&nested, 1, NULL, &outer));
    float rows[12];
    at(rows, 5);
    const hd_handle first = {0, 0};
    OK(hd_scene_set_transform(inner, first, rows));
    OK(hd_scene_commit(inner, NULL));
    CHECK(seen(inner, 5, 0) == 0 && seen(inner, 0, 0) == NOTHING);
    CHECK(seen(outer, 0, 0) == 0 && seen(outer, 5, 0) == NOTHING);
    OK(hd_scene_set_item(outer, first, &nested));
    OK(hd_scene_commit(outer, NULL));
    CHECK(seen(outer, 5, 0) == 0 && seen(outer, 0, 0) == NOTHING);

    /* A scene in itself is the scene as it was. */
    hd_handle itself;
    at(rows, 20);
    nested = item_of(NULL, outer);
    nested.transforms = rows;
    nested.transform_count = 1;
    OK(hd_scene_insert(outer, &nested, &itself));
    OK(hd_scene_commit(outer, NULL));
    CHECK(seen(outer, 5, 0) == 0 && seen(outer, 25, 0) == 0 && seen(outer, 45, 0) == NOTHING);
    hd_tree_free(tree);
    hd_scene_free(inner);
    CHECK(seen(outer, 25, 0) == 0);
    hd_scene_free(outer);
}

int main(void) {
    items_come_and_go();
    scenes_in_scenes_stay_as_they_were();
    puts("changes: passed");
    return 0;
}
