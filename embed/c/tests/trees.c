/* Trees and rays: right answers, and what becomes of bad input. */
#include "check.h"

static void known_hits(void) {
    const uint32_t qualities[] = {HD_QUALITY_DEFAULT, HD_QUALITY_FAST, HD_QUALITY_MEDIUM, HD_QUALITY_HIGH};
    for (int i = 0; i < 4; i++) {
        hd_tree *tree = floor_tree(qualities[i]);
        for (uint32_t y = 0; y < COLUMNS; y++) {
            for (uint32_t x = 0; x < COLUMNS; x++) {
                check_floor(tree, x, y, 0);
                check_floor(tree, x, y, 1);
            }
        }
        hd_ray past = ray_of(-1.0f, 3.0f, 1.0f, 0.0f, 0.0f, -1.0f);
        hd_hit hit;
        bool occluded = true;
        OK(hd_intersect(tree, &past, &hit));
        CHECK(hit.prim_id == HD_NO_PRIM && isinf(hit.t));
        OK(hd_occluded(tree, &past, &occluded));
        CHECK(!occluded);

        hd_tree_info info;
        memset(&info, 0, sizeof info);
        info.struct_size = sizeof info;
        OK(hd_tree_describe(tree, &info));
        CHECK(info.triangle_count == 2 * SQUARES && info.node_count > 1 && info.byte_count > 256 * info.node_count);
        CHECK(info.bounds_min[0] == 0.0f && info.bounds_max[1] == (float)COLUMNS && info.bounds_max[2] == 0.0f);
        hd_tree_free(tree);
    }
}

static void batches_are_single_rays(void) {
    enum { COUNT = 1000 };
    static hd_ray rays[COUNT];
    static hd_hit hits[COUNT];
    static bool occluded[COUNT];
    hd_tree *tree = floor_tree(HD_QUALITY_DEFAULT);
    int found = 0;
    for (int i = 0; i < COUNT; i++) {
        float x = (float)(i % 37) - 5.0f, y = (float)(i % 29);
        rays[i] = ray_of(x, y, 3.0f, (float)(i % 7) * 0.25f - 0.7f, (float)(i % 5) * 0.3f - 0.7f, i % 11 ? -1.0f : 1.0f);
    }
    OK(hd_intersect_many(tree, rays, hits, COUNT));
    OK(hd_occluded_many(tree, rays, occluded, COUNT));
    for (int i = 0; i < COUNT; i++) {
        hd_hit hit;
        bool any;
        OK(hd_intersect(tree, &rays[i], &hit));
        OK(hd_occluded(tree, &rays[i], &any));
        CHECK(memcmp(&hit, &hits[i], sizeof hit) == 0 && any == occluded[i] && any == (hit.prim_id != HD_NO_PRIM));
        found += any;
    }
    CHECK(found > COUNT / 4 && found < COUNT);
    OK(hd_intersect_many(tree, NULL, NULL, 0));

    /* None is traced if one is not a number. */
    memset(hits, 0x55, sizeof hits);
    memset(occluded, 1, sizeof occluded);
    rays[777].direction[1] = NAN;
    FAILS(HD_ERROR_VALUE, "ray 777", hd_intersect_many(tree, rays, hits, COUNT));
    FAILS(HD_ERROR_VALUE, "ray 777", hd_occluded_many(tree, rays, occluded, COUNT));
    for (size_t i = 0; i < sizeof hits; i++) {
        CHECK(((const unsigned char *)hits)[i] == 0x55);
    }
    CHECK(occluded[0] && occluded[COUNT - 1]);
    check_floor(tree, 3, 4, 0);
    hd_tree_free(tree);
}

static void meshes_of_all_forms(void) {
    const float apart[] = {0, 0, 0, NAN, 1, 0, 0, NAN, 0, 1, 0, NAN, 0, 0, -1, NAN, 1, 0, -1, NAN, 0, 1, -1};
    hd_mesh mesh = mesh_of(apart, 6, NULL, 0);
    mesh.vertex_stride = 16;
    hd_tree *tree = NULL;
    OK(hd_tree_build(&mesh, NULL, &tree));
    hd_ray ray = ray_of(0.25f, 0.5f, -3.0f, 0.0f, 0.0f, 1.0f);
    hd_hit hit;
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.t == 2.0f && hit.u == 0.25f && hit.v == 0.5f && hit.prim_id == 1);
    ray.t_min = 2.5f;
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.t == 3.0f && hit.prim_id == 0);
    hd_tree_free(tree);

    /* As a program knows it that was compiled with the first header. */
    mesh.struct_size = offsetof(hd_mesh, index_size);
    mesh.index_size = 77;
    mesh.position_format = 77;
    OK(hd_tree_build(&mesh, NULL, &tree));
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.t == 3.0f && hit.prim_id == 0);
    hd_tree_free(tree);

    /* 16 bits a number, at 0.5 q + (-1, 2, 3), and 16 bits an index. */
    const int16_t quantised[] = {2, -4, -6, 99, 4, -4, -6, 99, 2, -2, -6};
    const uint16_t indices[] = {0, 1, 2};
    mesh = mesh_of(NULL, 3, NULL, 3);
    mesh.positions = quantised;
    mesh.vertex_stride = 8;
    mesh.indices = indices;
    mesh.index_size = 2;
    mesh.position_format = HD_POSITIONS_I16;
    const float scale[3] = {0.5f, 0.5f, 0.5f}, offset[3] = {-1.0f, 2.0f, 3.0f};
    memcpy(mesh.scale, scale, sizeof scale);
    memcpy(mesh.offset, offset, sizeof offset);
    ray = ray_of(0.25f, 0.5f, -3.0f, 0.0f, 0.0f, 1.0f);
    OK(hd_tree_build(&mesh, NULL, &tree));
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.t == 3.0f && hit.u == 0.25f && hit.v == 0.5f && hit.prim_id == 0);
    hd_tree_free(tree);
    /* A scale of nothing is one of 1. */
    const uint16_t whole[] = {0, 0, 9, 1, 0, 9, 0, 1, 9};
    mesh = mesh_of(NULL, 3, NULL, 0);
    mesh.positions = whole;
    mesh.position_format = HD_POSITIONS_U16;
    OK(hd_tree_build(&mesh, NULL, &tree));
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.t == 12.0f && hit.prim_id == 0);
    hd_tree_free(tree);

    mesh = mesh_of(NULL, 0, NULL, 0);
    OK(hd_tree_build(&mesh, NULL, &tree));
    OK(hd_intersect(tree, &ray, &hit));
    CHECK(hit.prim_id == HD_NO_PRIM);
    hd_tree_free(tree);
}

static void bad_meshes_are_refused(void) {
    float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    uint32_t indices[] = {0, 1, 2, 0, 1, 3};
    const hd_mesh good = mesh_of(corners, 3, indices, 3);
    hd_mesh mesh;
    hd_tree *tree = NULL;
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_tree_build(&good, NULL, NULL));
    FAILS(HD_ERROR_NULL, "mesh is NULL", hd_tree_build(NULL, NULL, &tree));
    mesh = good, mesh.positions = NULL;
    FAILS(HD_ERROR_NULL, "mesh->positions", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.indices = NULL;
    FAILS(HD_ERROR_NULL, "mesh->indices", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.positions = (const float *)((const char *)corners + 1);
    FAILS(HD_ERROR_ALIGNMENT, "mesh->positions", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.index_size = 3;
    FAILS(HD_ERROR_VALUE, "index_size is 3", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.position_format = 3;
    FAILS(HD_ERROR_VALUE, "position_format is 3", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.position_format = HD_POSITIONS_U16, mesh.vertex_stride = 7;
    FAILS(HD_ERROR_SIZE, "a multiple of 2 from 6 on", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.index_count = 5;
    FAILS(HD_ERROR_SIZE, "multiple of three", hd_tree_build(&mesh, NULL, &tree));
    mesh = mesh_of(corners, 2, NULL, 0);
    FAILS(HD_ERROR_SIZE, "multiple of three", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.vertex_stride = 8;
    FAILS(HD_ERROR_SIZE, "vertex_stride is 8", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.vertex_stride = 14;
    FAILS(HD_ERROR_SIZE, "vertex_stride is 14", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.vertex_count = SIZE_MAX;
    FAILS(HD_ERROR_SIZE, "no such memory", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.index_count = SIZE_MAX / 2;
    FAILS(HD_ERROR_SIZE, "no such memory", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.index_count = 6;
    FAILS(HD_ERROR_VALUE, "triangle 1 has the index 3", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.struct_size = sizeof mesh + 8;
    FAILS(HD_ERROR_VERSION, "hd_mesh", hd_tree_build(&mesh, NULL, &tree));
    mesh = good, mesh.struct_size = 0;
    FAILS(HD_ERROR_VERSION, "hd_mesh", hd_tree_build(&mesh, NULL, &tree));
    const float bad[] = {NAN, INFINITY, -INFINITY, 5e12f};
    for (int i = 0; i < 4; i++) {
        corners[7] = bad[i];
        FAILS(HD_ERROR_VALUE, "triangle 0 has the corner", hd_tree_build(&good, NULL, &tree));
    }
    corners[7] = 1.0f;

    hd_build_options options;
    memset(&options, 0, sizeof options);
    FAILS(HD_ERROR_VERSION, "hd_build_options", hd_tree_build(&good, &options, &tree));
    options.struct_size = sizeof options;
    options.quality = 4;
    FAILS(HD_ERROR_VALUE, "quality is 4", hd_tree_build(&good, &options, &tree));
    options.quality = HD_QUALITY_FAST, options.reserved = 1;
    FAILS(HD_ERROR_VALUE, "options->reserved is 1", hd_tree_build(&good, &options, &tree));

    /* Whoever failed has no tree, and can go on. */
    CHECK(tree == NULL);
    OK(hd_tree_build(&good, NULL, &tree));
    hd_tree_free(tree);
}

static void bad_calls_are_refused(void) {
    hd_tree *tree = floor_tree(HD_QUALITY_FAST);
    hd_ray ray = ray_of(0.5f, 0.25f, 1.0f, 0.0f, 0.0f, -1.0f);
    hd_hit hit;
    bool occluded;
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_intersect(NULL, &ray, &hit));
    FAILS(HD_ERROR_NULL, "ray is NULL", hd_intersect(tree, NULL, &hit));
    FAILS(HD_ERROR_NULL, "hit is NULL", hd_intersect(tree, &ray, NULL));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_occluded(NULL, &ray, &occluded));
    FAILS(HD_ERROR_NULL, "ray is NULL", hd_occluded(tree, NULL, &occluded));
    FAILS(HD_ERROR_NULL, "occluded is NULL", hd_occluded(tree, &ray, NULL));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_intersect_many(NULL, &ray, &hit, 1));
    FAILS(HD_ERROR_NULL, "rays is NULL", hd_intersect_many(tree, NULL, &hit, 1));
    FAILS(HD_ERROR_NULL, "hits is NULL", hd_intersect_many(tree, &ray, NULL, 1));
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_occluded_many(NULL, &ray, &occluded, 1));
    FAILS(HD_ERROR_NULL, "rays is NULL", hd_occluded_many(tree, NULL, &occluded, 1));
    FAILS(HD_ERROR_NULL, "occluded is NULL", hd_occluded_many(tree, &ray, NULL, 1));
    FAILS(HD_ERROR_SIZE, "no such memory", hd_intersect_many(tree, &ray, &hit, SIZE_MAX));
    FAILS(HD_ERROR_ALIGNMENT, "ray is at", hd_intersect(tree, (const hd_ray *)((const char *)&ray + 1), &hit));
    float *const numbers = ray.origin;
    for (int i = 0; i < 3; i++) {
        numbers[i] = NAN;
        FAILS(HD_ERROR_VALUE, "NaN", hd_intersect(tree, &ray, &hit));
        FAILS(HD_ERROR_VALUE, "NaN", hd_occluded(tree, &ray, &occluded));
        numbers[i] = 0.5f;
    }
    ray.t_max = NAN;
    FAILS(HD_ERROR_VALUE, "NaN", hd_intersect(tree, &ray, &hit));

    hd_tree_info info;
    memset(&info, 0, sizeof info);
    FAILS(HD_ERROR_VERSION, "hd_tree_info", hd_tree_describe(tree, &info));
    info.struct_size = sizeof info;
    FAILS(HD_ERROR_NULL, "tree is NULL", hd_tree_describe(NULL, &info));
    FAILS(HD_ERROR_NULL, "info is NULL", hd_tree_describe(tree, NULL));
    check_floor(tree, 7, 9, 1);
    hd_tree_free(tree);
    hd_tree_free(NULL);
}

int main(void) {
    CHECK(hd_abi_version() == HD_ABI_VERSION);
    CHECK(strcmp(hd_last_error(), "") == 0);
    CHECK(strcmp(hd_status_name(HD_ERROR_VALUE), "HD_ERROR_VALUE") == 0);
    CHECK(strcmp(hd_status_name(-1), "unknown status") == 0);
    CHECK(strlen(hd_instruction_set()) > 0);
    known_hits();
    batches_are_single_rays();
    meshes_of_all_forms();
    bad_meshes_are_refused();
    bad_calls_are_refused();
    puts("trees: passed");
    return 0;
}
