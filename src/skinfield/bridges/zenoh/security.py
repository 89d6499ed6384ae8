"""Certificates, and who may read and write: what goes into zenoh's configuration."""

from dataclasses import dataclass
from pathlib import Path

from skinfield.errors import InputError

# What one who reads does, and what reaches it; what one who writes does, and what it hears.
_ASKS = ["declare_subscriber", "query", "declare_liveliness_subscriber", "liveliness_query"]
_GIVES = ["put", "delete", "reply", "declare_queryable", "liveliness_token"]


@dataclass(frozen=True, kw_only=True)
class Tls:
    """Certificates, as PEM files.

    Parameters
    ----------
    ca : Path
        Of the authority that signed the certificates of all who take part.
    certificate, key : Path, optional
        Of this process; who listens needs them, and who connects to a `mutual` one.
    mutual : bool
        Whether who connects here must have a certificate of that authority too.
    verify_name : bool
        Whether the certificate of whom is connected to must name the address in use.
    """

    ca: Path
    certificate: Path | None = None
    key: Path | None = None
    mutual: bool = True
    verify_name: bool = True

    def __post_init__(self) -> None:
        for name in ("ca", "certificate", "key"):
            path = getattr(self, name)
            if path is not None and not Path(path).is_file():
                raise InputError(f"{name} is {str(path)!r}, expected a PEM file that exists")
        if (self.certificate is None) != (self.key is None):
            raise InputError("certificate and key belong together, expected both or none")

    def values(self) -> dict[str, object]:
        """Of zenoh's `transport/link/tls`."""
        found: dict[str, object] = {
            "root_ca_certificate": str(self.ca),
            "enable_mtls": self.mutual,
            "verify_name_on_connect": self.verify_name,
        }
        if self.certificate is not None:
            for side in ("listen", "connect"):
                found[f"{side}_certificate"] = str(self.certificate)
                found[f"{side}_private_key"] = str(self.key)
        return found


@dataclass(frozen=True, kw_only=True)
class Access:
    """Who may do what; whatever is not listed is denied. Needs certificates.

    Parameters
    ----------
    read : tuple of str
        Common names of the certificates of those who may read here.
    write : tuple of str
        Of those who may write here: from whom anything is taken.
    keys : tuple of str
        Key expressions; `**` does not match chunks that begin with `@`, so they are listed.
    """

    read: tuple[str, ...] = ()
    write: tuple[str, ...] = ()
    keys: tuple[str, ...] = ("skinfield/**",)

    def __post_init__(self) -> None:
        for name in ("read", "write", "keys"):
            values = tuple(getattr(self, name))
            if not all(isinstance(value, str) and value for value in values):
                raise InputError(f"{name} is {values!r}, expected texts that are not empty")
            object.__setattr__(self, name, values)

    def values(self) -> dict[str, object]:
        """Of zenoh's `access_control`."""
        rules, subjects, policies = [], [], []
        for what, names in (("read", self.read), ("write", self.write)):
            if not names:
                continue
            incoming, outgoing = (_ASKS, _GIVES) if what == "read" else (_GIVES, _ASKS)
            for flow, messages in (("ingress", incoming), ("egress", outgoing)):
                rules.append(
                    {
                        "id": f"{what}-{flow}",
                        "permission": "allow",
                        "flows": [flow],
                        "messages": messages,
                        "key_exprs": list(self.keys),
                    }
                )
            subjects.append({"id": f"may-{what}", "cert_common_names": list(names)})
            policies.append(
                {"rules": [f"{what}-ingress", f"{what}-egress"], "subjects": [f"may-{what}"]}
            )
        return {
            "enabled": True,
            "default_permission": "deny",
            "rules": rules,
            "subjects": subjects,
            "policies": policies,
        }
