"""Results as other programs see them: netCDF's data model, read by xarray."""
import h5py
import xarray


def groups_of(path):
    """Names of all groups of histories and envelopes that hold datasets."""
    found = ["history"]

    def see(name, item):
        if isinstance(item, h5py.Group) and any(isinstance(one, h5py.Dataset)
                                                for one in item.values()):
            found.append(name)

    with h5py.File(path, "r") as file:
        for top in ("history", "envelope"):
            if top in file:
                file[top].visititems(lambda name, item, top=top: see(f"{top}/{name}", item))
    return found


def require_labels(path, **axes):
    """Fails unless xarray opens each group of histories and envelopes of results.h5 with a
    coordinate for each dimension, units and a long name for each array. `axes`: the expected
    dimensions of arrays, by their path with __ for /."""
    seen = {}
    for group in groups_of(path):
        with xarray.open_dataset(path, group=group, engine="h5netcdf") as data:
            for name, one in data.variables.items():
                seen[f"{group}/{name}"] = one.dims
                bare = [axis for axis in one.dims if axis not in data.coords]
                lacks = [word for word in ("units", "long_name") if not one.attrs.get(word)]
                if bare or lacks:
                    raise SystemExit(f"{path}: {group}/{name}: without coordinate: {bare}; without "
                                     f"attribute: {lacks}")
    for place, dims in axes.items():
        if seen.get(place.replace("__", "/")) != dims:
            raise SystemExit(f"{path}: {place} has dimensions {seen.get(place.replace('__', '/'))}, "
                             f"not {dims}")
