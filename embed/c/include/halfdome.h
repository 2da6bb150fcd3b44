/* halfdome's ray-tracing kernel for C (C99 and later) and C++.
 *
 * Every function that can fail gives an hd_status and, if that is not HD_OK, leaves a message for hd_last_error. One that
 * fails has written nothing, save NULL for the handle it was to make, and what was given to it can be used as before.
 * Pointers must be NULL or point to as much memory as the function says, which outputs must not share with inputs. NULL,
 * wrong sizes and counts, NaN, and blobs of another kind or version are told by a status. No panic leaves the library.
 *
 * Any number of threads may trace a tree or a scene at the same time. What changes one (hd_tree_refit, hd_scene_insert and its
 * kin, hd_scene_commit) needs it for itself; what a scene has been given does not change under it.
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
 * Positions are three floats.
 */
#define HD_POSITIONS_F32 0

/**
 * Positions are three uint16_t, of which each is q * scale + offset.
 */
#define HD_POSITIONS_U16 1

/**
 * Positions are three int16_t, likewise.
 */
#define HD_POSITIONS_I16 2

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
 * Spheres of four numbers: centre and radius.
 */
#define HD_SPHERES 0

/**
 * Flat discs of seven numbers: centre, radius, and a normal of any length but 0.
 */
#define HD_DISCS 1

/**
 * Spheres swept along segments, of eight numbers: centre and radius at both ends.
 */
#define HD_LINEAR_CURVES 2

/**
 * Spheres swept along Bézier curves, of sixteen numbers: four control points with a radius each.
 */
#define HD_CUBIC_CURVES 3

/**
 * A filter's verdict: the hit does not count, and the ray goes on.
 */
#define HD_REJECT 0

/**
 * The hit counts.
 */
#define HD_ACCEPT 1

/**
 * The hit counts, and the search ends with it, whether there are nearer ones or not.
 */
#define HD_STOP 2

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
 * A tree of triangles that move. Scenes alone have it, as their rays have a time.
 */
typedef struct hd_moving_tree hd_moving_tree;

/**
 * A tree of points or curves. Scenes alone have it.
 */
typedef struct hd_round_tree hd_round_tree;

/**
 * A scene, ready to be traced as it was at its last commit.
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
     * x, y and z of each vertex: floats, unless position_format says otherwise.
     */
    const void *positions;
    /**
     * How many vertices there are.
     */
    size_t vertex_count;
    /**
     * Bytes from one vertex to the next, a multiple of the size of a number, and at least that of three; 0 stands for
     * that.
     */
    size_t vertex_stride;
    /**
     * Three vertices for each triangle, counter-clockwise when seen from the front: uint32_t, unless index_size says
     * otherwise. NULL: 0, 1, 2, 3 …
     */
    const void *indices;
    /**
     * How many indices there are, a multiple of three; without indices vertex_count is.
     */
    size_t index_count;
    /**
     * The bytes of an index: 4, or 2 for uint16_t. 0 stands for 4.
     */
    uint32_t index_size;
    /**
     * One of HD_POSITIONS_*.
     */
    uint32_t position_format;
    /**
     * What positions of 16 bits are multiplied by. All 0 stands for all 1.
     */
    float scale[3];
    /**
     * What is added to positions of 16 bits then.
     */
    float offset[3];
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
     * The triangle's index in its mesh; HD_NO_PRIM if nothing was hit.
     */
    uint32_t prim_id;
} hd_hit;

/**
 * What a hit with a point or a curve says of the surface.
 */
typedef struct hd_round_surface {
    /**
     * The point, which is nearer to the surface than origin + t * direction.
     */
    float point[3];
    /**
     * How far off the point along the normal, or against it, a ray has to start that leaves the surface.
     */
    float offset;
    /**
     * Unit normal of the side that the ray has met.
     */
    float normal[3];
    /**
     * 1 if that is the outside, or of a disc the side that it faces, else 0.
     */
    uint32_t is_front;
    /**
     * Unit normal for shading: without the edges that cubic curves have.
     */
    float shading_normal[3];
    /**
     * 0
     */
    uint32_t reserved;
} hd_round_surface;

/**
 * Something in a scene: either a tree, a scene, a tree that moves or one of points or curves, of which there may be
 * many instances.
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
     * Twelve numbers for each key: the three rows of a matrix, four numbers each, that takes the item's points (x, y,
     * z, 1) to the scene. NULL: where its own coordinates say. A single one that flattens to nothing, such as a scale
     * of zero, hides the item; one that flattens nearly is an HD_ERROR_VALUE.
     */
    const float *transforms;
    /**
     * How many transforms there are. Several are where the item is at times evenly spaced from 0 to 1; in between
     * their elements are interpolated.
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
    /**
     * The tree of triangles that move, or NULL.
     */
    const struct hd_moving_tree *moving;
    /**
     * The tree of points or curves, or NULL.
     */
    const struct hd_round_tree *round;
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
     * The item that has the mesh: its index in the scene that has the item.
     */
    uint32_t item;
    /**
     * How many nested scenes enclose the item.
     */
    uint32_t depth;
    /**
     * The index of the path of nested scenes to the item among all paths; hd_scene_instances lists the items on it.
     */
    uint64_t path;
} hd_scene_hit;

/**
 * The name of an item, valid until the item is removed. Numbers of items are used again, but under other names.
 */
typedef struct hd_handle {
    /**
     * The item's index: the item field of its hits.
     */
    uint32_t index;
    /**
     * How many items had this index before.
     */
    uint32_t generation;
} hd_handle;

/**
 * What a commit did.
 */
typedef struct hd_commit {
    /**
     * sizeof(hd_commit)
     */
    size_t struct_size;
    /**
     * How many items were inserted, changed or removed.
     */
    size_t changed;
    /**
     * How many items rays can see if their masks allow; others are empty, flat or removed, or reach beyond the limits.
     */
    size_t seen;
    /**
     * The expected number of nodes of the scene's own tree that a random ray visits.
     */
    float cost;
    /**
     * 1 if that tree was built anew, and 0 if it was fitted to the changes.
     */
    uint32_t rebuilt;
} hd_commit;

/**
 * Judges a hit: HD_REJECT, HD_ACCEPT or HD_STOP. user is what was given with it. It must return, by no exception and
 * no longjmp; it may trace other rays.
 */
typedef uint32_t (*hd_filter)(void *user, const struct hd_hit *hit);

/**
 * hd_filter for the hits of a scene.
 */
typedef uint32_t (*hd_scene_filter)(void *user, const struct hd_scene_hit *hit);

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * The HD_ABI_VERSION of this library. A program works with it if its own is the same.
 */
uint32_t hd_abi_version(void);

/**
 * What was wrong in the last call of this thread that failed: a sentence in English, in UTF-8; empty if none failed.
 * It can be read until the thread's next call that fails, and belongs to the library.
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
 * Moves a tree to where the triangles of a mesh are now, which are as many as before and in the same order: quicker
 * than a new tree, which pays when *decay, the cost of rays as a multiple of what it was when the tree was built, is
 * beyond 1.5. decay may be NULL. Hits are those of a new tree.
 *
 * Nobody may be tracing the tree. Scenes that it is in keep it as it was until hd_scene_set_item puts it there again;
 * the tree is then copied first, as is one that was opened in a blob.
 *
 * HD_ERROR_VALUE if triangles that rays could hit are gone or new ones have come, as where two corners become one; the
 * tree is then as it was.
 */
hd_status hd_tree_refit(struct hd_tree *tree, const struct hd_mesh *mesh, float *decay);

/**
 * Writes the three corners of a triangle, x, y and z each, to nine numbers. Looks through the whole tree.
 */
hd_status hd_tree_triangle(const struct hd_tree *tree, uint32_t prim_id, float *corners);

/**
 * Describes a tree.
 */
hd_status hd_tree_describe(const struct hd_tree *tree, struct hd_tree_info *info);

/**
 * Frees a tree, which nobody may be using. NULL is allowed.
 */
void hd_tree_free(struct hd_tree *tree);

/**
 * Finds the nearest hit of a ray; of equally near ones that of the lowest prim_id. A ray hits nothing if t_min >
 * t_max, or if it is out of limits: coordinates of the origin up to 2^42, and the largest of the direction from 2^-50
 * to 2^50.
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
 * Writes a tree as a blob: to bytes, if there is room for it, and its length to *size. Where bytes is NULL and
 * capacity is 0 only the length is written.
 */
hd_status hd_tree_save(const struct hd_tree *tree, uint8_t *bytes, size_t capacity, size_t *size);

/**
 * Makes a tree of a blob that is traced where it lies, without a copy: bytes is a multiple of HD_BLOB_ALIGNMENT, and
 * stays as it is until the tree, and every scene that it is in, is freed. The blob is checked once, so that whatever
 * it holds is safe to trace.
 */
hd_status hd_tree_open(const uint8_t *bytes, size_t size, struct hd_tree **tree);

/**
 * Makes a tree of a blob, which is copied and may lie anywhere.
 */
hd_status hd_tree_load(const uint8_t *bytes, size_t size, struct hd_tree **tree);

/**
 * Builds a tree of key_count meshes, which are copied: the same triangles, in the same order, where they are at times
 * evenly spaced from 0 to 1; in between they move in straight lines. options may be NULL. Put it in a scene as
 * hd_item's moving.
 *
 * HD_ERROR_VALUE if there is no mesh, or if they differ in the number of triangles.
 */
hd_status hd_moving_tree_build(const struct hd_mesh *keys,
                               size_t key_count,
                               const struct hd_build_options *options,
                               struct hd_moving_tree **tree);

/**
 * Frees a tree. Scenes that it is in keep it. NULL is allowed.
 */
void hd_moving_tree_free(struct hd_moving_tree *tree);

/**
 * Builds a tree of count points or curves of a kind, of which the numbers lie one after the other, and are copied.
 * options may be NULL. Those that no ray can hit are left out: of no radius, too far away, or with a NaN. Put it in a
 * scene as hd_item's round. A hit's prim_id is the place in the array; u is where along a curve it is, 0 to 1, or a
 * disc's distance from the centre in radii; v is 0.
 */
hd_status hd_round_tree_build(uint32_t kind,
                              const float *numbers,
                              size_t count,
                              const struct hd_build_options *options,
                              struct hd_round_tree **tree);

/**
 * What a ray meets of a single point or curve, which has these numbers: after a hit, those of its prim_id. The ray is
 * in the item's own space, as the numbers are.
 *
 * HD_ERROR_VALUE if the ray does not hit it.
 */
hd_status hd_round_surface_at(uint32_t kind,
                              const float *numbers,
                              const struct hd_ray *ray,
                              struct hd_round_surface *surface);

/**
 * Frees a tree. Scenes that it is in keep it. NULL is allowed.
 */
void hd_round_tree_free(struct hd_round_tree *tree);

/**
 * Builds a scene of count items, whose numbers are their places in the array. options may be NULL. The trees and
 * scenes in it can be freed before it; blobs that trees were opened in have to stay. With a count of 0 the scene is
 * empty, for items that are inserted. Where items move each frame, HD_QUALITY_FAST is right, as the scene's own tree,
 * which is over items, is built again now and then.
 */
hd_status hd_scene_build(const struct hd_item *items,
                         size_t count,
                         const struct hd_build_options *options,
                         struct hd_scene **scene);

/**
 * Finds the nearest hit of a ray; of equally near ones that of the lowest item, then prim_id, then path.
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
 * Writes the items that are scenes on the path to a hit of this scene, the outermost first: their indices, each in the
 * scene that has it, as many as hit->depth says. instances has room for capacity of them.
 */
hd_status hd_scene_instances(const struct hd_scene *scene,
                             const struct hd_scene_hit *hit,
                             uint32_t *instances,
                             size_t capacity);

/**
 * Frees a scene, which nobody may be using. Scenes that it is in stay as they are. NULL is allowed.
 */
void hd_scene_free(struct hd_scene *scene);

/**
 * Writes a scene as of its last commit as a blob, with all trees and scenes in it: to bytes, if there is room for it,
 * and its length to *size. Where bytes is NULL and capacity is 0 only the length is written.
 */
hd_status hd_scene_save(const struct hd_scene *scene, uint8_t *bytes, size_t capacity, size_t *size);

/**
 * Makes a scene of a blob whose trees are traced where they lie, without a copy: bytes is a multiple of
 * HD_BLOB_ALIGNMENT, and stays as it is until the scene, and every scene that it is in, is freed. Items and handles
 * are those of hd_scene_load.
 */
hd_status hd_scene_open(const uint8_t *bytes, size_t size, struct hd_scene **scene);

/**
 * Makes a scene of a blob, which is copied and may lie anywhere, and is checked so that whatever it holds is safe to
 * trace. Items have the numbers that they had, and handles of generation 0.
 */
hd_status hd_scene_load(const uint8_t *bytes, size_t size, struct hd_scene **scene);

/**
 * Adds an item, which rays see from the next commit on. Items of hd_scene_build have handles too: their index, and
 * generation 0.
 *
 * This and the other functions that change a scene need it for themselves: nobody may be tracing it. Scenes that it is
 * in keep it as it was until hd_scene_set_item puts it there again; it is then copied first.
 */
hd_status hd_scene_insert(struct hd_scene *scene, const struct hd_item *item, struct hd_handle *handle);

/**
 * Removes an item: rays see it until the next commit, and its handle is valid no more.
 */
hd_status hd_scene_remove(struct hd_scene *scene, struct hd_handle handle);

/**
 * Puts an item where a transform of twelve numbers (the three rows of a matrix, four numbers each) takes its points,
 * from the next commit on. One that flattens hides it; one with a NaN or nearly flat is refused, and the item stays
 * where it was.
 */
hd_status hd_scene_set_transform(struct hd_scene *scene, struct hd_handle handle, const float *rows);

/**
 * Says which rays see an item from the next commit on: those whose mask has a bit in common. 0 stands for all bits.
 */
hd_status hd_scene_set_mask(struct hd_scene *scene, struct hd_handle handle, uint32_t mask);

/**
 * Exchanges an item as a whole, from the next commit on: what it is, such as a tree that was refitted, where, and who
 * sees it. Its handle stays.
 */
hd_status hd_scene_set_item(struct hd_scene *scene, struct hd_handle handle, const struct hd_item *item);

/**
 * Makes all changes since the last commit, which rays see from now on. The scene's own tree is fitted to them, or
 * built again where that is better. commit may be NULL. If it fails the scene is as of the last commit, and the
 * changes still wait.
 */
hd_status hd_scene_commit(struct hd_scene *scene, struct hd_commit *commit);

/**
 * Gives the handle of the item that a hit names by its item field. HD_ERROR_VALUE if it was removed since.
 */
hd_status hd_scene_handle(const struct hd_scene *scene, uint32_t item, struct hd_handle *handle);

/**
 * Finds the nearest hit of a ray that a filter accepts, or the one that it stops at. The filter sees the hits that are
 * nearer than what it accepted so far, each once, roughly from near to far.
 */
hd_status hd_intersect_filtered(const struct hd_tree *tree,
                                const struct hd_ray *ray,
                                hd_filter filter,
                                void *user,
                                struct hd_hit *hit);

/**
 * Finds out whether a ray hits anything that a filter accepts.
 */
hd_status hd_occluded_filtered(const struct hd_tree *tree,
                               const struct hd_ray *ray,
                               hd_filter filter,
                               void *user,
                               bool *occluded);

/**
 * Writes the nearest hits of a ray, nearest first: as many as there are and as hits has room for, and their number to
 * *count. With a capacity of 0, *count is the number of all hits.
 */
hd_status hd_nearest_hits(const struct hd_tree *tree,
                          const struct hd_ray *ray,
                          struct hd_hit *hits,
                          size_t capacity,
                          size_t *count);

/**
 * hd_intersect_filtered for a scene.
 */
hd_status hd_scene_intersect_filtered(const struct hd_scene *scene,
                                      const struct hd_scene_ray *ray,
                                      hd_scene_filter filter,
                                      void *user,
                                      struct hd_scene_hit *hit);

/**
 * hd_occluded_filtered for a scene.
 */
hd_status hd_scene_occluded_filtered(const struct hd_scene *scene,
                                     const struct hd_scene_ray *ray,
                                     hd_scene_filter filter,
                                     void *user,
                                     bool *occluded);

/**
 * hd_nearest_hits for a scene.
 */
hd_status hd_scene_nearest_hits(const struct hd_scene *scene,
                                const struct hd_scene_ray *ray,
                                struct hd_scene_hit *hits,
                                size_t capacity,
                                size_t *count);

/**
 * Finds the point of a tree's triangles that is closest to a point (three numbers) and not farther than radius, which
 * may be infinite. Writes its coordinates to the three numbers of closest, and to hit which triangle it is on, with
 * the distance as t; where there is none, HD_NO_PRIM, and closest is all 0. closest may be NULL. Of equally close
 * triangles the lowest counts.
 */
hd_status hd_closest_point(const struct hd_tree *tree,
                           const float *point,
                           float radius,
                           float *closest,
                           struct hd_hit *hit);

/**
 * hd_closest_point for a scene at a time (0 to 1) and for items whose mask has a bit in common with mask, of which 0
 * stands for all bits.
 */
hd_status hd_scene_closest_point(const struct hd_scene *scene,
                                 const float *point,
                                 float radius,
                                 float time,
                                 uint32_t mask,
                                 float *closest,
                                 struct hd_scene_hit *hit);

/**
 * Finds the triangles that have a point in common with a box, whose least and greatest corner are three numbers each,
 * and writes as many of their indices as prim_ids has room for, in an order that is the tree's own. *count is the
 * number of all of them, which may be more than capacity. Touching counts.
 */
hd_status hd_overlaps(const struct hd_tree *tree,
                      const float *min,
                      const float *max,
                      uint32_t *prim_ids,
                      size_t capacity,
                      size_t *count);

/**
 * hd_overlaps for a scene at a time (0 to 1) and for items whose mask has a bit in common with mask, of which 0 stands
 * for all bits. Hits have a t of 0.
 */
hd_status hd_scene_overlaps(const struct hd_scene *scene,
                            const float *min,
                            const float *max,
                            float time,
                            uint32_t mask,
                            struct hd_scene_hit *hits,
                            size_t capacity,
                            size_t *count);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* HALFDOME_H */
