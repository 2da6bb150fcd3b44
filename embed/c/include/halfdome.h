/* halfdome's ray-tracing kernel for C (C99 and later) and C++.
 *
 * Every function that can fail gives an hd_status and, if that is not HD_OK, leaves a message for hd_last_error. One that
 * fails has written nothing, save NULL for the handle it was to make, and what was given to it can be used as before.
 * Pointers must be NULL or point to as much memory as the function says, which outputs must not share with inputs. NULL,
 * wrong sizes and counts, NaN, and blobs of another kind or version are told by a status. No panic leaves the library.
 *
 * Trees and scenes do not change once they are made: any number of threads may trace one at the same time.
 *
 * Structures that may grow begin with struct_size: set it to their sizeof and all that you do not need to zero, and a
 * program that was compiled with this header will work with later libraries of the same HD_ABI_VERSION. hd_ray and hd_hit
 * stay as they are. All numbers are those of the target, blobs are little-endian.
 *
 * This file is generated from embed/c/src: do not edit it. */

#ifndef HALFDOME_H
#define HALFDOME_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/**
 * The version of this interface: what a program compiled with this header needs.
 */
#define HD_ABI_VERSION 1

/**
 * What the library thinks best: HD_QUALITY_HIGH.
 */
#define HD_QUALITY_DEFAULT 0

/**
 * Built quickly, for trees that are traced little.
 */
#define HD_QUALITY_FAST 1

/**
 * In between.
 */
#define HD_QUALITY_MEDIUM 2

/**
 * Traced quickly.
 */
#define HD_QUALITY_HIGH 3

/**
 * The prim_id of a ray that hits nothing.
 */
#define HD_NO_PRIM 4294967295

/**
 * What the address of a blob must be a multiple of, if it is to be traced where it lies.
 */
#define HD_BLOB_ALIGNMENT 64

/**
 * What became of a call.
 */
enum hd_status
#if defined(__cplusplus) || __STDC_VERSION__ >= 202311L
  : int32_t
#endif // defined(__cplusplus) || __STDC_VERSION__ >= 202311L
 {
    /**
     * Done.
     */
    HD_OK = 0,
    /**
     * A pointer is NULL that must not be.
     */
    HD_ERROR_NULL = 1,
    /**
     * A count, a length or a stride is wrong.
     */
    HD_ERROR_SIZE = 2,
    /**
     * A pointer is not aligned as it must be.
     */
    HD_ERROR_ALIGNMENT = 3,
    /**
     * A number is NaN, infinite or out of range, an index too.
     */
    HD_ERROR_VALUE = 4,
    /**
     * A structure's struct_size, or a blob, is of a version that this library does not know.
     */
    HD_ERROR_VERSION = 5,
    /**
     * A blob is none, is truncated or is damaged.
     */
    HD_ERROR_BLOB = 6,
    /**
     * There is more than a tree or a scene can hold.
     */
    HD_ERROR_LIMIT = 7,
    /**
     * A mistake in this library. All handles can be used as before.
     */
    HD_ERROR_INTERNAL = 8,
};
#ifndef __cplusplus
#if __STDC_VERSION__ >= 202311L
typedef enum hd_status hd_status;
#else
typedef int32_t hd_status;
#endif // __STDC_VERSION__ >= 202311L
#endif // __cplusplus

/**
 * A scene, ready to be traced.
 */
typedef struct hd_scene hd_scene;

/**
 * A tree of triangles, ready to be traced.
 */
typedef struct hd_tree hd_tree;

/**
 * Triangles.
 */
typedef struct hd_mesh {
    /**
     * sizeof(hd_mesh)
     */
    size_t struct_size;
    /**
     * x, y and z of each vertex.
     */
    const float *positions;
    /**
     * How many vertices there are.
     */
    size_t vertex_count;
    /**
     * Bytes from one vertex to the next, a multiple of 4, at least 12; 0 stands for 12.
     */
    size_t vertex_stride;
    /**
     * Three vertices for each triangle, counter-clockwise when seen from the front. NULL: 0, 1, 2, 3 …
     */
    const uint32_t *indices;
    /**
     * How many indices there are, a multiple of three; without indices vertex_count is.
     */
    size_t index_count;
} hd_mesh;

/**
 * How to build a tree.
 */
typedef struct hd_build_options {
    /**
     * sizeof(hd_build_options)
     */
    size_t struct_size;
    /**
     * One of HD_QUALITY_*.
     */
    uint32_t quality;
    /**
     * 0
     */
    uint32_t reserved;
} hd_build_options;

/**
 * A tree in figures.
 */
typedef struct hd_tree_info {
    /**
     * sizeof(hd_tree_info)
     */
    size_t struct_size;
    /**
     * Triangles in it. Of those that it was built from some may be missing: those with two equal corners.
     */
    size_t triangle_count;
    /**
     * Nodes of the tree.
     */
    size_t node_count;
    /**
     * Memory of the tree in bytes.
     */
    size_t byte_count;
    /**
     * The least x, y and z; +infinity if there are no triangles.
     */
    float bounds_min[3];
    /**
     * The greatest x, y and z; -infinity if there are no triangles.
     */
    float bounds_max[3];
} hd_tree_info;

/**
 * The points origin + t direction, from t_min to t_max.
 */
typedef struct hd_ray {
    /**
     * Where t is 0.
     */
    float origin[3];
    /**
     * The least t that counts.
     */
    float t_min;
    /**
     * Where the ray goes. It need not have unit length; t counts in its lengths.
     */
    float direction[3];
    /**
     * The greatest t that counts; may be infinite.
     */
    float t_max;
} hd_ray;

/**
 * Where a ray meets a triangle: at origin + t direction, which is (1 - u - v) v0 + u v1 + v v2.
 */
typedef struct hd_hit {
    /**
     * Distance in lengths of the direction; infinite if nothing was hit.
     */
    float t;
    /**
     * Weight of the triangle's second corner.
     */
    float u;
    /**
     * Weight of the triangle's third corner.
     */
    float v;
    /**
     * The triangle's number in its mesh; HD_NO_PRIM if nothing was hit.
     */
    uint32_t prim_id;
} hd_hit;

/**
 * Something in a scene: either a tree or a scene, of which there may be many instances.
 */
typedef struct hd_item {
    /**
     * sizeof(hd_item)
     */
    size_t struct_size;
    /**
     * The tree, or NULL.
     */
    const struct hd_tree *tree;
    /**
     * The scene, or NULL.
     */
    const struct hd_scene *scene;
    /**
     * Twelve numbers for each key: the three rows of a matrix, four numbers each, that takes the item's points (x, y, z, 1)
     * to the scene. NULL: where its own coordinates say. A single one that flattens, such as a scale of zero, hides the item.
     */
    const float *transforms;
    /**
     * How many transforms there are. Several are where the item is at times evenly spaced from 0 to 1; in between their
     * elements are interpolated.
     */
    size_t transform_count;
    /**
     * Rays see it whose mask has a bit in common with it. 0 stands for all bits.
     */
    uint32_t mask;
    /**
     * 0
     */
    uint32_t reserved;
} hd_item;

/**
 * A ray with what a scene asks of it besides.
 */
typedef struct hd_scene_ray {
    /**
     * The ray.
     */
    struct hd_ray ray;
    /**
     * When, from 0 to 1; less counts as 0, and more as 1.
     */
    float time;
    /**
     * Which items it sees: those whose mask has a bit in common with it, at every level. 0 stands for all bits.
     */
    uint32_t mask;
} hd_scene_ray;

/**
 * Where a ray meets a triangle of a scene.
 */
typedef struct hd_scene_hit {
    /**
     * Where, and which triangle of its mesh. t is the same in all spaces.
     */
    struct hd_hit hit;
    /**
     * The item that has the mesh: its number in the scene that has the item.
     */
    uint32_t geometry_id;
    /**
     * How many items that are scenes the ray went through on its way there.
     */
    uint32_t depth;
    /**
     * The number of that way among all in the scene; hd_scene_instances lists the items.
     */
    uint64_t path;
} hd_scene_hit;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The HD_ABI_VERSION of this library. A program works with it if its own is the same.
 */
uint32_t hd_abi_version(void);

/**
 * What was wrong in the last call of this thread that failed: a sentence in English, in UTF-8; empty if none failed. It
 * can be read until the thread's next call that fails, and belongs to the library.
 */
const char *hd_last_error(void);

/**
 * The name of a status, such as "HD_ERROR_NULL"; of another number "unknown status".
 */
const char *hd_status_name(int32_t status);

/**
 * Builds a tree of a mesh, which is copied. options may be NULL. The same triangles and options give the same tree on
 * every machine. Hits have the numbers of the triangles in the mesh.
 */
hd_status hd_tree_build(const struct hd_mesh *mesh, const struct hd_build_options *options, struct hd_tree **tree);

/**
 * Describes a tree.
 */
hd_status hd_tree_describe(const struct hd_tree *tree, struct hd_tree_info *info);

/**
 * Frees a tree, which nobody may be using. NULL is allowed.
 */
void hd_tree_free(struct hd_tree *tree);

/**
 * Finds the nearest hit of a ray; of equally near ones that of the lowest prim_id. A ray hits nothing if t_min > t_max,
 * or if it is out of limits: coordinates of the origin up to 2^42, and the largest of the direction from 2^-50 to 2^50.
 */
hd_status hd_intersect(const struct hd_tree *tree, const struct hd_ray *ray, struct hd_hit *hit);

/**
 * Finds out whether a ray hits anything.
 */
hd_status hd_occluded(const struct hd_tree *tree, const struct hd_ray *ray, bool *occluded);

/**
 * hd_intersect for count rays: several times as quick as one by one. If a ray has a NaN none is traced.
 */
hd_status hd_intersect_many(const struct hd_tree *tree, const struct hd_ray *rays, struct hd_hit *hits, size_t count);

/**
 * hd_occluded for count rays, likewise.
 */
hd_status hd_occluded_many(const struct hd_tree *tree, const struct hd_ray *rays, bool *occluded, size_t count);

/**
 * The instruction set that rays are traced with: "avx512", "avx2", "sse2", "portable" or "scalar". The environment
 * variable HALFDOME_ISA can name a lesser one. Hits are the same with all.
 */
const char *hd_instruction_set(void);

/**
 * Writes a tree as a blob: to bytes, if there is room for it, and its length to *size. Where bytes is NULL and capacity
 * is 0 only the length is written.
 */
hd_status hd_tree_save(const struct hd_tree *tree, uint8_t *bytes, size_t capacity, size_t *size);

/**
 * Makes a tree of a blob that is traced where it lies, without a copy: bytes is a multiple of HD_BLOB_ALIGNMENT, and
 * stays as it is until the tree, and every scene that it is in, is freed. The blob is checked once, so that whatever it
 * holds is safe to trace.
 */
hd_status hd_tree_open(const uint8_t *bytes, size_t size, struct hd_tree **tree);

/**
 * Makes a tree of a blob, which is copied and may lie anywhere.
 */
hd_status hd_tree_load(const uint8_t *bytes, size_t size, struct hd_tree **tree);

/**
 * Builds a scene of count items, whose numbers are their places in the array. options may be NULL. The trees and scenes
 * in it can be freed before it; blobs that trees were opened in have to stay.
 */
hd_status hd_scene_build(const struct hd_item *items,
                         size_t count,
                         const struct hd_build_options *options,
                         struct hd_scene **scene);

/**
 * Finds the nearest hit of a ray; of equally near ones that of the lowest geometry_id, then prim_id, then path.
 */
hd_status hd_scene_intersect(const struct hd_scene *scene, const struct hd_scene_ray *ray, struct hd_scene_hit *hit);

/**
 * Finds out whether a ray hits anything.
 */
hd_status hd_scene_occluded(const struct hd_scene *scene, const struct hd_scene_ray *ray, bool *occluded);

/**
 * hd_scene_intersect for count rays. If a ray has a NaN none is traced.
 */
hd_status hd_scene_intersect_many(const struct hd_scene *scene,
                                  const struct hd_scene_ray *rays,
                                  struct hd_scene_hit *hits,
                                  size_t count);

/**
 * hd_scene_occluded for count rays, likewise.
 */
hd_status hd_scene_occluded_many(const struct hd_scene *scene,
                                 const struct hd_scene_ray *rays,
                                 bool *occluded,
                                 size_t count);

/**
 * Writes the items that are scenes on the way to a hit of this scene, the outermost first: their numbers, each in the scene
 * that has it, as many as hit->depth says. instances has room for capacity of them.
 */
hd_status hd_scene_instances(const struct hd_scene *scene,
                             const struct hd_scene_hit *hit,
                             uint32_t *instances,
                             size_t capacity);

/**
 * Frees a scene, which nobody may be using. Scenes that it is in stay as they are. NULL is allowed.
 */
void hd_scene_free(struct hd_scene *scene);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HALFDOME_H */
