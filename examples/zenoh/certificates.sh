#!/bin/sh
# Makes your own authority, unless its ca.key is here, and its certificates for NAME... (default
# engine and viewer). NAME is the CN by which access is given; the alternative names must hold the
# address by which others connect. ca.key stays where this runs.
set -e
[ $# -gt 0 ] || set -- engine viewer
[ -f ca.key ] || openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes \
    -days 3650 -subj "/CN=skin authority" -keyout ca.key -out ca.pem
for name in "$@"; do
    openssl req -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes \
        -subj "/CN=$name" -keyout "$name.key" -out "$name.csr"
    printf "subjectAltName=DNS:localhost,IP:127.0.0.1,DNS:robot" > "$name.ext"
    openssl x509 -req -in "$name.csr" -CA ca.pem -CAkey ca.key -CAcreateserial -days 825 \
        -extfile "$name.ext" -out "$name.pem"
done
