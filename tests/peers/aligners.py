"""How peers lay the views of a scan onto each other: common-frame-from-camera matrices, one a view."""

import numpy as np
import open3d as o3d
import small_gicp

VOXEL_M = 0.002
NEIGHBOURS = 20
THREADS = 2


def moved(pose, points):
    return points @ pose[:3, :3].T + pose[:3, 3]


def grow(views, first, align):
    """Each view onto all before it; `align(view, model, number)` gives its pose."""
    poses = [first]
    model = moved(first, views[0])
    for number, view in enumerate(views[1:], 1):
        poses.append(align(view, model, number))
        model = np.vstack([model, moved(poses[-1], view)])
    return np.array(poses)


def open3d_identity(views):
    """Point to point from where the camera was, as the paper's reference implementation does."""
    registration = o3d.pipelines.registration
    criteria = registration.ICPConvergenceCriteria(max_iteration=1000)

    def align(view, model, _):
        return registration.registration_icp(cloud(view), cloud(model), 0.02, np.eye(4),
                                             registration.TransformationEstimationPointToPoint(),
                                             criteria).transformation
    return grow(views, np.eye(4), align)


def gicp(views, starts, reach_m=0.01):
    """Generalised ICP from given poses, with steps down to a hundredth of a millimetre."""
    def align(view, model, number):
        target, tree = small_gicp.preprocess_points(model, VOXEL_M, NEIGHBOURS, THREADS)
        source, _ = small_gicp.preprocess_points(view, VOXEL_M, NEIGHBOURS, THREADS)
        return small_gicp.align(target, source, tree, starts[number], 'GICP', reach_m, THREADS, 100, 1e-4,
                                1e-5).T_target_source
    return grow(views, starts[0], align)


def cloud(points):
    return o3d.geometry.PointCloud(o3d.utility.Vector3dVector(points))
